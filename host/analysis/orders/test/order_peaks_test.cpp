#include "host/analysis/orders/order_peaks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "host/analysis/orders/test/sweep.hpp"

namespace roadbalance {
namespace {

constexpr int kRows = 32, kTurns = 32;

OrderSpectrum spectrum_of(const std::vector<test::OrderSignal>& signals, double noise, int blocks) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal(0.0, noise);
  OrderWaterfall waterfall({1, kRows, kTurns, 7.5, 1000.0, 5.0});
  TurnBlock block;
  block.rotation_hz = 12.0;
  block.values.resize(kRows * kTurns, 1);
  for (int i = 0; i < blocks; ++i) {
    for (Eigen::Index n = 0; n < block.values.rows(); ++n) {
      block.values(n, 0) = noise > 0.0 ? normal(random) : 0.0;
      for (const auto& signal : signals) block.values(n, 0) += signal.at(static_cast<double>(n) / kRows);
    }
    waterfall.add(block);
  }
  return waterfall.spectrum(0);
}

TEST(FindPeaks, SaysOrderAndAmplitudeTheHighestFirst) {
  const auto peaks = find_peaks(spectrum_of({{1.0, 3.0}, {2.37, 2.0}, {5.0, 1.0}}, 0.01, 5), 10);
  ASSERT_EQ(peaks.size(), 3U);
  EXPECT_NEAR(peaks[0].order, 1.0, 1e-3);
  EXPECT_NEAR(peaks[1].order, 2.37, 1e-3);  // a tenth of a line is 3e-3
  EXPECT_NEAR(peaks[2].order, 5.0, 1e-3);
  EXPECT_NEAR(peaks[1].amplitude, 2.0, 0.01);
}

TEST(FindPeaks, TakesNoNoiseForAPeak) {
  for (const int blocks : {1, 4, 50})
    EXPECT_TRUE(find_peaks(spectrum_of({}, 1.0, blocks), 10).empty()) << blocks;
  EXPECT_TRUE(find_peaks(spectrum_of({}, 0.0, 1), 10).empty()) << "nothing at all";
  EXPECT_TRUE(find_peaks({}, 10).empty());
}

TEST(FindPeaks, TakesNoResonanceForAPeak) {
  // A wheel hops at 13 Hz with a damping of 0.2; at 18 turns a second that is order 0.72.
  OrderSpectrum hop{1.0 / kTurns, 3.8 / kTurns, {}, {}};
  for (int k = 0; k < 7 * kTurns; ++k) {
    const double ratio = k * 18.0 / kTurns / 13.0;
    hop.amplitude.push_back(1.0 / std::hypot(1.0 - ratio * ratio, 2.0 * 0.2 * ratio));
  }
  EXPECT_TRUE(find_peaks(hop, 10).empty());
}

TEST(FindPeaks, TakesNothingForAPeakThatTheHighestMayHaveLeft) {
  EXPECT_EQ(find_peaks(spectrum_of({{1.0, 1.0}, {3.0, 2e-4}}, 0.0, 1), 10).size(), 1U);
  EXPECT_EQ(find_peaks(spectrum_of({{1.0, 1.0}, {3.0, 5e-4}}, 0.0, 1), 10).size(), 2U);
}

TEST(FindPeaks, GivesNoMoreThanWanted) {
  EXPECT_EQ(find_peaks(spectrum_of({{1.0, 3.0}, {2.37, 2.0}, {5.0, 1.0}}, 0.01, 5), 2).size(), 2U);
}

}  // namespace
}  // namespace roadbalance
