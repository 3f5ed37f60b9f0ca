#include "common/bus/remark.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace roadbalance {
namespace {

TEST(Remark, ComesBackAsItWasSent) {
  const auto bytes = encode(Remark{7, 2, 3, "the scale rests on ± 2 %"});
  EXPECT_LT(bytes.size(), 1400U) << "one datagram";
  const auto got = decode_remark(bytes);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->time_ns, 7);
  EXPECT_EQ(got->number, 2);
  EXPECT_EQ(got->remarks, 3);
  EXPECT_EQ(got->text, "the scale rests on ± 2 %");
}

TEST(Remark, ThatIsTooLongIsCutBetweenCharacters) {
  const auto got = decode_remark(encode(Remark{0, 0, 1, std::string(kMostRemarkBytes - 1, 'a') + "±b"}));
  ASSERT_TRUE(got);
  EXPECT_EQ(got->text, std::string(kMostRemarkBytes - 1, 'a'));
}

TEST(Remark, OfNoSentenceSaysSo) {
  const auto none = remarks_of(5, {});
  ASSERT_EQ(none.size(), 1U);
  EXPECT_EQ(decode_remark(encode(none[0]))->remarks, 0);
  const auto two = remarks_of(5, {"a", "b"});
  ASSERT_EQ(two.size(), 2U);
  EXPECT_EQ(two[1].number, 1);
  EXPECT_EQ(two[1].remarks, 2);
  EXPECT_EQ(two[1].text, "b");
}

TEST(Remark, RefusesWhatIsNoText) {
  const auto good = encode(Remark{0, 0, 1, "aXb"});
  for (const int byte : {0xFF, 0xC3, 0x1B}) {
    auto bytes = good;
    *std::ranges::find(bytes, 'X') = static_cast<std::uint8_t>(byte);
    EXPECT_FALSE(decode_remark(bytes)) << byte;
  }
}

TEST(Remark, RefusesNumbersThatCannotBe) {
  for (const auto& [number, remarks] : {std::pair{-1, 1}, {1, 1}, {1, 0}, {0, -1}, {0, kMostRemarks + 1}})
    EXPECT_FALSE(decode_remark(encode(Remark{0, number, remarks, ""}))) << number << " of " << remarks;
}

}  // namespace
}  // namespace roadbalance
