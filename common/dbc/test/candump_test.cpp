#include "common/dbc/candump.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

TEST(Candump, ReadsShortAndLongIdentifiers) {
  const auto short_id = parse_candump("(46408.589503) can0 0AA#25B525B5").value();
  EXPECT_EQ(short_id.time_ns, 46'408'589'503'000);
  EXPECT_EQ(short_id.interface, "can0");
  EXPECT_EQ(short_id.frame.id, 0x0AAU);
  EXPECT_FALSE(short_id.frame.extended);
  EXPECT_FALSE(short_id.frame.is_fd);
  EXPECT_EQ(short_id.frame.size, 4U);
  EXPECT_EQ(short_id.frame.data[1], 0xB5);
  const auto long_id = parse_candump("(0.000001) vcan12 18FEF100#").value();
  EXPECT_TRUE(long_id.frame.extended);
  EXPECT_EQ(long_id.frame.id, 0x18FEF100U);
  EXPECT_EQ(long_id.frame.size, 0U);
}

TEST(Candump, ReadsFramesOfCanFd) {
  const auto twelve = parse_candump("(1.000000) can0 123##1000102030405060708090A0B").value();
  EXPECT_TRUE(twelve.frame.is_fd);
  EXPECT_EQ(twelve.frame.size, 12U);
  EXPECT_EQ(twelve.frame.data[11], 0x0B);
  const auto longest = parse_candump("(1.000000) can0 123##0" + std::string(126, '0') + "5A").value();
  EXPECT_EQ(longest.frame.size, 64U);
  EXPECT_EQ(longest.frame.data[63], 0x5A);
}

TEST(Candump, RefusesEveryOtherLine) {
  for (const char* line : {"",
                           "(",
                           "(1.000000)",
                           "(1.000000) can0",
                           "(1.000000) can0 0AA",
                           "1.000000 can0 0AA#00",
                           "(1.0) can0 0AA#00",
                           "(x.000000) can0 0AA#00",
                           "(-1.000000) can0 0AA#00",
                           "(1.000000) can0 FFF#00",
                           "(1.000000) can0 0A#00",
                           "(1.000000) can0 2AAAAAAAA#00",
                           "(1.000000) can0 2AAAAAAA#00",
                           "(1.000000) can0 0AA#0",
                           "(1.000000) can0 0AA#0G",
                           "(1.000000) can0 0AA#R",
                           "(1.000000) can0 0AA##",
                           "(1.000000) can0 0AA##G00",
                           "(1.000000) can0 0AA##1112233445566778899",
                           "(1.000000) can0 0AA#112233445566778899",
                           "(1.000000)can0 0AA#00",
                           "(1.000000)  0AA#00"})
    EXPECT_FALSE(parse_candump(line)) << line;
  // CAN FD has no 28 bytes.
  EXPECT_FALSE(parse_candump("(1.000000) can0 0AA##0" + std::string(56, '0')));
}

}  // namespace
}  // namespace roadbalance
