#include "firmware/backends/can_signal.hpp"

#include <array>
#include <cmath>
#include <sstream>
#include <vector>

#include <gtest/gtest.h>

#include "common/test/source.hpp"

namespace roadbalance {
namespace {

const std::string kData = "firmware/backends/test/data/";

CanFrame frame(const std::string& data) {
  return parse_candump("(1.000000) can0 123#" + data).value();
}

TEST(CanSignal, DecodesARealCarsWheelSpeedsAsPublished) {
  // Toyota RAV4, frame 0AA: 0.01 km/h, offset -67.67; front right, front left, rear right, rear left.
  constexpr std::array<std::size_t, 4> kPlaceOfColumn{1, 0, 3, 2};  // columns: FL, FR, RL, RR
  std::istringstream log(test::read_source(kData + "rav4.candump.log"));
  std::istringstream table(test::read_source(kData + "rav4_wheel_speed.csv"));
  std::string line;
  std::getline(table, line);
  ASSERT_EQ(line, "time_s,front_left_m_s,front_right_m_s,rear_left_m_s,rear_right_m_s");
  int frames = 0;
  while (std::getline(log, line)) {
    const auto f = parse_candump(line);
    ASSERT_TRUE(f) << line;
    if (f->id != 0x0AA) continue;
    ASSERT_TRUE(std::getline(table, line)) << "the table ends before the log";
    std::istringstream row(line);
    std::string cell;
    std::getline(row, cell, ',');
    EXPECT_EQ(f->time_ns, std::llround(std::stod(cell) * 1e6) * 1'000);
    for (const std::size_t place : kPlaceOfColumn) {
      const CanSignal speed_km_h{.order = ByteOrder::kBigEndian,
                                 .start_bit = 16 * static_cast<int>(place) + 7,
                                 .length = 16,
                                 .scale = 0.01,
                                 .offset = -67.67};
      std::getline(row, cell, ',');
      // The table has nine digits; one count is 2.8e-3 m/s.
      EXPECT_NEAR(speed_km_h.value(*f).value() / 3.6, std::stod(cell), 5.1e-8) << line;
    }
    ++frames;
  }
  EXPECT_FALSE(std::getline(table, line)) << "the log ends before the table";
  EXPECT_EQ(frames, 4974);
}

TEST(CanSignal, FollowsTheBitNumberingOfBothByteOrders) {
  const CanFrame f = frame("0123456789ABCDEF");
  const auto value = [&](ByteOrder order, int start, int length) {
    return CanSignal{.order = order, .start_bit = start, .length = length}.value(f).value();
  };
  EXPECT_EQ(value(ByteOrder::kBigEndian, 7, 16), 0x0123);
  EXPECT_EQ(value(ByteOrder::kLittleEndian, 0, 16), 0x2301);
  EXPECT_EQ(value(ByteOrder::kBigEndian, 3, 12), 0x123);  // across a byte, from its middle
  EXPECT_EQ(value(ByteOrder::kLittleEndian, 4, 12), 0x230);
  EXPECT_EQ(value(ByteOrder::kBigEndian, 56, 1), 1);
  EXPECT_EQ(value(ByteOrder::kBigEndian, 7, 64), std::ldexp(0x01234567, 32) + 0x89ABCDEF);
}

TEST(CanSignal, ReadsNegativeNumbers) {
  const CanSignal signal{.start_bit = 7, .length = 12, .is_signed = true, .scale = 0.5, .offset = 1.0};
  EXPECT_EQ(signal.value(frame("FFF0")).value(), 0.5);
  EXPECT_EQ(signal.value(frame("8000")).value(), -1'023.0);
  EXPECT_EQ(signal.value(frame("7FF0")).value(), 1'024.5);
  const CanSignal wide{.order = ByteOrder::kLittleEndian, .start_bit = 0, .length = 64, .is_signed = true};
  EXPECT_EQ(wide.value(frame("FEFFFFFFFFFFFFFF")).value(), -2.0);
}

TEST(CanSignal, IsNotThereInAShortFrame) {
  const CanSignal signal{.start_bit = 7, .length = 16};
  EXPECT_TRUE(signal.value(frame("0102")));
  EXPECT_FALSE(signal.value(frame("01")));
  EXPECT_FALSE(signal.value(frame("")));
  EXPECT_FALSE((CanSignal{.start_bit = 64, .length = 1}.value(frame("0102030405060708"))));
  EXPECT_FALSE((CanSignal{.length = 0}.value(frame("01"))));
  EXPECT_FALSE((CanSignal{.length = 65}.value(frame("01"))));
}

TEST(Candump, ReadsShortAndLongIdentifiers) {
  const auto short_id = parse_candump("(46408.589503) can0 0AA#25B525B5").value();
  EXPECT_EQ(short_id.time_ns, 46'408'589'503'000);
  EXPECT_EQ(short_id.interface, "can0");
  EXPECT_EQ(short_id.id, 0x0AAU);
  EXPECT_FALSE(short_id.extended);
  EXPECT_EQ(short_id.size, 4U);
  EXPECT_EQ(short_id.data[1], 0xB5);
  const auto long_id = parse_candump("(0.000001) vcan12 18FEF100#").value();
  EXPECT_TRUE(long_id.extended);
  EXPECT_EQ(long_id.id, 0x18FEF100U);
  EXPECT_EQ(long_id.size, 0U);
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
                           "(1.000000) can0 0AA##1112233",
                           "(1.000000) can0 0AA#112233445566778899",
                           "(1.000000)can0 0AA#00",
                           "(1.000000)  0AA#00"})
    EXPECT_FALSE(parse_candump(line)) << line;
}

}  // namespace
}  // namespace roadbalance
