#include "common/bus/tap.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

TEST(Tap, ComesBackAsItWasSent) {
  Tap sent{.node = 2, .time_ns = 5, .number = 9, .channel = 11};
  for (std::size_t c = 0; c < kAccelerations; ++c) {
    sent.first_m_s2[c] = -1.5 * static_cast<double>(c);
    sent.peak_m_s2[c] = 2.5 * static_cast<double>(c);
  }
  const auto got = decode_tap(encode(sent));
  ASSERT_TRUE(got);
  EXPECT_EQ(got->node, 2);
  EXPECT_EQ(got->time_ns, 5);
  EXPECT_EQ(got->number, 9);
  EXPECT_EQ(got->channel, 11);
  EXPECT_EQ(got->first_m_s2, sent.first_m_s2);
  EXPECT_EQ(got->peak_m_s2, sent.peak_m_s2);
}

TEST(Tap, RefusesAChannelThatCannotBe) {
  for (const std::int32_t channel : {-1, kAccelerations})
    EXPECT_FALSE(decode_tap(encode(Tap{.node = 1, .channel = channel}))) << channel;
}

TEST(Tap, RefusesANodeThatCannotBe) {
  for (const std::int32_t node : {-1, 0, 10'000}) EXPECT_FALSE(decode_tap(encode(Tap{.node = node}))) << node;
}

}  // namespace
}  // namespace roadbalance
