#include "host/analysis/orders/order_waterfall.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "host/analysis/orders/test/sweep.hpp"

namespace roadbalance {
namespace {

constexpr int kRows = 32, kTurns = 32;
constexpr OrderWaterfall::Settings kSettings{2, kRows, kTurns, 7.5, 200.0, 5.0};

/// A block in which channel 0 shows `signal` and channel 1 nothing.
TurnBlock block_of(const test::OrderSignal& signal, double rotation_hz, double offset = 0.0) {
  TurnBlock block;
  block.rotation_hz = rotation_hz;
  block.values.setZero(kRows * kTurns, 2);
  for (Eigen::Index n = 0; n < block.values.rows(); ++n)
    block.values(n, 0) = offset + signal.at(static_cast<double>(n) / kRows);
  return block;
}

double highest(const OrderSpectrum& spectrum) {
  return *std::max_element(spectrum.amplitude.begin() + 6, spectrum.amplitude.end());
}

TEST(OrderWaterfall, ShowsAmplitudesWhereverTheyFallBetweenLines) {
  for (double order = 1.0; order < 1.0 + 1.0 / kTurns; order += 0.1 / kTurns) {
    OrderWaterfall waterfall(kSettings);
    waterfall.add(block_of({order, 2.5, 0.7}, 12.0));
    EXPECT_NEAR(highest(waterfall.spectrum(0)), 2.5, 2.5 * 6e-4) << order;  // 0.0044 dB
    EXPECT_EQ(highest(waterfall.spectrum(1)), 0.0);
  }
}

TEST(OrderWaterfall, ShowsTheMeanAtOrderZero) {
  OrderWaterfall waterfall(kSettings);
  waterfall.add(block_of({3.0, 1.0}, 12.0, -4.0));
  EXPECT_NEAR(waterfall.spectrum(0).amplitude[0], 4.0, 1e-4);
}

TEST(OrderWaterfall, ShowsNoiseAsItsBandwidthSays) {
  // White noise of variance 1 over 32 rows a turn has the one-sided density 2 / 32 per order.
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  OrderWaterfall waterfall(kSettings);
  constexpr int kBlocks = 400;
  for (int i = 0; i < kBlocks; ++i) {
    TurnBlock block = block_of({1.0, 0.0}, 12.0);
    for (Eigen::Index n = 0; n < block.values.rows(); ++n) block.values(n, 0) = normal(random);
    waterfall.add(block);
  }
  const OrderSpectrum spectrum = waterfall.spectrum(0);
  const double expected = std::sqrt(2.0 * (2.0 / kRows) * spectrum.noise_bandwidth);
  double square = 0.0;
  for (std::size_t k = 10; k < 200; ++k) square += std::pow(spectrum.amplitude[k] / expected, 2) / 190.0;
  // 190 lines, a third of them independent, of 400 blocks: 1 / sqrt(400 * 60) = 0.6 %.
  EXPECT_NEAR(square, 1.0, 0.025);
}

TEST(OrderWaterfall, KeepsSpeedsApart) {
  OrderWaterfall waterfall(kSettings);
  waterfall.add(block_of({1.0, 1.0}, 12.0));
  waterfall.add(block_of({1.0, 3.0}, 23.0));
  waterfall.add(block_of({1.0, 3.0}, 24.0));
  const auto rows = waterfall.rows(0);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].from_hz, 10.0);
  EXPECT_EQ(rows[1].to_hz, 25.0);
  EXPECT_NEAR(highest(rows[0].spectrum), 1.0, 1e-3);
  EXPECT_NEAR(highest(rows[1].spectrum), 3.0, 3e-3);
  EXPECT_EQ(rows[1].spectrum.averages[0], 2);
  EXPECT_NEAR(highest(waterfall.spectrum(0)), std::sqrt((1.0 + 9.0 + 9.0) / 3.0), 3e-3) << "rms over blocks";
}

TEST(OrderWaterfall, ShowsNoOrderThatTheSamplesDoNotHold) {
  OrderWaterfall waterfall(kSettings);
  waterfall.add(block_of({1.0, 1.0}, 12.0));  // up to 7.5
  waterfall.add(block_of({1.0, 1.0}, 39.0));  // up to 200 Hz / 40 turns a second
  const auto rows = waterfall.rows(0);
  EXPECT_EQ(rows[0].spectrum.amplitude.size(), 7.5 * kTurns + 1);
  EXPECT_EQ(rows[1].spectrum.amplitude.size(), 5.0 * kTurns + 1);
  const OrderSpectrum whole = waterfall.spectrum(0);
  EXPECT_EQ(whole.averages[5 * kTurns], 2);
  EXPECT_EQ(whole.averages[5 * kTurns + 1], 1);
}

TEST(OrderWaterfall, LeavesOutAChannelThatLeftItsRangeAndWhatIsTooFast) {
  OrderWaterfall waterfall(kSettings);
  TurnBlock block = block_of({1.0, 1.0}, 12.0);
  block.overload = 0b01;
  waterfall.add(block);
  EXPECT_TRUE(waterfall.spectrum(0).amplitude.empty());
  EXPECT_FALSE(waterfall.spectrum(1).amplitude.empty());
  waterfall.add(block_of({1.0, 1.0}, 5.0 * OrderWaterfall::kMostClasses));
  EXPECT_EQ(waterfall.too_fast(), 1);
  EXPECT_TRUE(waterfall.spectrum(0).amplitude.empty());
}

TEST(OrderWaterfall, RefusesNonsense) {
  auto settings = kSettings;
  settings.highest_order = 17.0;
  EXPECT_THROW(OrderWaterfall{settings}, std::invalid_argument);
  settings = kSettings;
  settings.class_hz = 0.0;
  EXPECT_THROW(OrderWaterfall{settings}, std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
