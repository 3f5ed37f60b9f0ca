#include "common/bus/display.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace roadbalance {
namespace {

constexpr std::size_t kDatagram = 1400;

TEST(Display, AnEnvelopeComesBackAsItWasSent) {
  Envelope sent{.node = 2, .channel = 11, .epoch = 5, .first = 1'000'000, .scans = 10, .time_ns = 77};
  sent.period_ps = 500'000'000;
  sent.bucket.assign(kMostBuckets, {-1.5F, 2.5F});
  sent.bucket[3] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::quiet_NaN()};
  const auto bytes = encode(sent);
  EXPECT_LT(bytes.size(), kDatagram);
  const auto got = decode_envelope(bytes);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->first, 1'000'000);
  EXPECT_EQ(got->period_ps, 500'000'000);
  ASSERT_EQ(got->bucket.size(), kMostBuckets);
  EXPECT_EQ(got->bucket[95].greatest, 2.5F);
  EXPECT_TRUE(std::isnan(got->bucket[3].least));
  sent.channel = 12;
  EXPECT_FALSE(decode_envelope(encode(sent))) << "a reference is none";
  sent.channel = 0;
  sent.scans = 0;
  EXPECT_FALSE(decode_envelope(encode(sent)));
}

TEST(Display, ARowOfAWaterfallComesBackAsItWasSent) {
  WaterfallRow sent{.of = {3, {2, 7}}, .speed_class = 15, .from_m_s = 30.0, .to_m_s = 32.0, .blocks = 9};
  sent.step = 1.0 / 32.0;
  sent.amplitude.assign(kMostWaterfallLines, 0.25F);
  const auto bytes = encode(sent);
  EXPECT_LT(bytes.size(), kDatagram);
  const auto got = decode_waterfall(bytes);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->of, sent.of);
  EXPECT_EQ(got->to_m_s, 32.0);
  EXPECT_EQ(got->amplitude, sent.amplitude);
  sent.of.wheel = 4;
  EXPECT_FALSE(decode_waterfall(encode(sent)));
  sent.of.wheel = 0;
  sent.state = static_cast<OrderState>(4);
  EXPECT_FALSE(decode_waterfall(encode(sent)));
}

}  // namespace
}  // namespace roadbalance
