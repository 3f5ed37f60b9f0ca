#include "host/analysis/spectra/envelopes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace roadbalance {
namespace {

constexpr double kScale = 0.01, kOffset = 50.0;

NodeConfig node() {
  NodeConfig node{"front", 3, 2000.0, {}};
  for (const double sign : {1.0, -1.0}) {
    ChannelConfig channel;
    channel.scale_m_s2_per_count = sign * kScale;
    channel.offset_counts = kOffset;
    node.channel.push_back(channel);
  }
  return node;
}

/// Noise in both channels, its scans kept.
class EnvelopeTest : public testing::Test {
 protected:
  ScanBlock block(std::int64_t number, std::int64_t epoch = 1) {
    ScanBlock block;
    block.header = {3,
                    epoch,
                    number + 1,
                    number * kScansPerBlock,
                    kScansPerBlock,
                    1'000'000'000 + number * kScansPerBlock * 500'000};
    block.period_ps = 500'000'000;
    for (auto& row : block.counts) row[0] = row[1] = noise_(random_);
    return block;
  }
  void add(std::int64_t number) {
    const ScanBlock next = block(number);
    for (const auto& row : next.counts) sent_.push_back(row[0]);
    meter_.add(next);
  }

  EnvelopeMeter meter_{node()};
  std::vector<std::int32_t> sent_;

 private:
  std::mt19937 random_{5};
  std::uniform_int_distribution<std::int32_t> noise_{-9000, 9000};
};

TEST_F(EnvelopeTest, HoldsTheLeastAndGreatestOfEachFiveMilliseconds) {
  for (int number = 0; number < 30; ++number) add(number);
  const auto got = meter_.envelope(0), turned = meter_.envelope(1);
  ASSERT_TRUE(got && turned);
  EXPECT_EQ(got->scans, 10);
  ASSERT_EQ(got->bucket.size(), 60U);
  EXPECT_EQ(got->first, 0);
  EXPECT_EQ(got->time_ns, 1'000'000'000);
  for (std::size_t k = 0; k < got->bucket.size(); ++k) {
    const auto from = sent_.begin() + static_cast<std::ptrdiff_t>(10 * k);
    const auto [least, greatest] = std::minmax_element(from, from + 10);
    EXPECT_FLOAT_EQ(got->bucket[k].least, static_cast<float>((*least - kOffset) * kScale));
    EXPECT_FLOAT_EQ(got->bucket[k].greatest, static_cast<float>((*greatest - kOffset) * kScale));
    EXPECT_FLOAT_EQ(turned->bucket[k].greatest, -got->bucket[k].least) << "a calibration with a minus";
  }
}

TEST_F(EnvelopeTest, OldBucketsMakeRoomForNewOnes) {
  for (int number = 0; number < 1000; ++number) add(number);
  const auto got = meter_.envelope(0);
  ASSERT_TRUE(got);
  ASSERT_EQ(got->bucket.size(), kMostBuckets);
  EXPECT_EQ(got->first, 2000 - static_cast<std::int64_t>(kMostBuckets));
  EXPECT_EQ(got->time_ns, 1'000'000'000 + got->first * 5'000'000);
  EXPECT_FLOAT_EQ(got->bucket.back().greatest,
                  static_cast<float>((*std::max_element(sent_.end() - 10, sent_.end()) - kOffset) * kScale));
}

TEST_F(EnvelopeTest, WhatDidNotComeIsNoNumber) {
  add(0);
  add(3);  // 40 scans are missing: four buckets
  const auto got = meter_.envelope(0);
  ASSERT_TRUE(got);
  ASSERT_EQ(got->bucket.size(), 8U);
  for (std::size_t k = 0; k < 8; ++k) EXPECT_EQ(std::isnan(got->bucket[k].least), 2 <= k && k < 6) << k;
}

TEST_F(EnvelopeTest, AHoleLongerThanAllThatIsHeldLeavesNothingOld) {
  for (int number = 0; number < 60; ++number) add(number);
  add(100'000);
  const auto got = meter_.envelope(0);
  ASSERT_TRUE(got);
  const auto known = std::ranges::count_if(got->bucket, [](const auto& b) { return !std::isnan(b.least); });
  EXPECT_EQ(known, 2);
}

TEST_F(EnvelopeTest, ANewEpochBeginsAnew) {
  for (int number = 0; number < 60; ++number) add(number);
  meter_.add(block(0, 2));
  const auto got = meter_.envelope(0);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->epoch, 2);
  EXPECT_EQ(got->first, 0);
  EXPECT_EQ(got->bucket.size(), 2U);
}

TEST_F(EnvelopeTest, SaysNothingOfChannelsThatAreNot) {
  EXPECT_FALSE(meter_.envelope(0)) << "nothing came";
  add(0);
  EXPECT_FALSE(meter_.envelope(2));
  EXPECT_FALSE(meter_.envelope(-1));
}

}  // namespace
}  // namespace roadbalance
