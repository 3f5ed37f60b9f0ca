// Analytic order signals through the whole chain: 600 samples a second, a wheel that runs up from 10 to 40
// turns a second, orders 1, 0.5, sqrt 2 and 2 with amplitudes 1, 1/2, sqrt 2 and 2.  The highest is order 2
// at 40 turns a second, 80 Hz of the 228 Hz that the interpolation passes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "host/analysis/orders/angle_resampler.hpp"
#include "host/analysis/orders/order_peaks.hpp"
#include "host/analysis/orders/order_vectors.hpp"
#include "host/analysis/orders/test/sweep.hpp"

namespace roadbalance {
namespace {

constexpr double kRateHz = 600.0, kRunUp_s = 60.0;
constexpr int kRows = 32, kSpectrumTurns = 32, kVectorTurns = 8;
constexpr double kDegree = std::numbers::pi / 180.0;
const test::Sweep kWheel{10.0, 30.0 / kRunUp_s};
const std::vector<test::OrderSignal> kSignals{{1.0, 1.0, 40.0 * kDegree},
                                              {0.5, 0.5, -100.0 * kDegree},
                                              {std::numbers::sqrt2, std::numbers::sqrt2, 10.0 * kDegree},
                                              {2.0, 2.0, 170.0 * kDegree}};

double signal_at(double time_s) {
  double sum = 0.0;
  for (const auto& signal : kSignals) sum += signal.at(kWheel.turns(time_s));
  return sum;
}

struct Chain {
  OrderWaterfall waterfall{{1, kRows, kSpectrumTurns, 7.0, 0.38 * kRateHz, 5.0}};
  OrderVectors vectors{
      {1, kRows, kVectorTurns, {1.0, 0.5, std::numbers::sqrt2, 2.0}, 0.38 * kRateHz, 5.0, {}}};
  TurnBlocks spectrum_blocks{{1, kRows, kSpectrumTurns, kSpectrumTurns / 4},
                             [this](const TurnBlock& block) { waterfall.add(block); }};
  TurnBlocks vector_blocks{{1, kRows, kVectorTurns, kVectorTurns},
                           [this](const TurnBlock& block) { vectors.add(block); }};
  AngleResampler resampler{{1, kRateHz, kRows, 5.0}, [this](const AngleRow& row) {
                             spectrum_blocks.add(row);
                             vector_blocks.add(row);
                           }};

  /// The wheel's angle with `angle_noise_rad` and the signal with `noise` (both rms).
  void run_up(double noise = 0.0, double angle_noise_rad = 0.0) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    for (int k = 0; k < std::lround(kRunUp_s * kRateHz); ++k) {
      const double t = k / kRateHz;
      const double angle = 2.0 * std::numbers::pi * kWheel.turns(t) + angle_noise_rad * normal(random);
      resampler.add(angle, Eigen::VectorXd::Constant(1, signal_at(t) + noise * normal(random)));
    }
  }
};

TEST(AnalyticOrders, SpectrumShowsThemWithinOnePercent) {
  Chain chain;
  chain.run_up();
  const auto peaks = find_peaks(chain.waterfall.spectrum(0), 10);
  ASSERT_EQ(peaks.size(), kSignals.size());
  for (const auto& signal : kSignals) {
    const auto found = std::find_if(peaks.begin(), peaks.end(), [&](const OrderPeak& peak) {
      return std::abs(peak.order - signal.order) < 0.5 / kSpectrumTurns;
    });
    ASSERT_NE(found, peaks.end()) << signal.order;
    std::printf("order %.4f as %.4f: amplitude off by %+.4f %%\n", signal.order, found->order,
                100.0 * (found->amplitude / signal.amplitude - 1.0));
    EXPECT_NEAR(found->order, signal.order, 0.003);
    EXPECT_NEAR(found->amplitude, signal.amplitude,
                0.001 * signal.amplitude);  // ten times better than asked for
  }
}

TEST(AnalyticOrders, EverySpeedOfTheWaterfallShowsThemWithinOnePercent) {
  Chain chain;
  chain.run_up();
  const auto rows = chain.waterfall.rows(0);
  ASSERT_EQ(rows.size(), 6U);
  for (const auto& row : rows)
    for (const auto& signal : kSignals) {
      const auto line = static_cast<std::size_t>(std::lround(signal.order * kSpectrumTurns));
      EXPECT_NEAR(row.spectrum.amplitude[line], signal.amplitude, 0.002 * signal.amplitude)
          << row.from_hz << " turns a second, order " << signal.order;
    }
}

TEST(AnalyticOrders, VectorsHaveAmplitudeAndPhase) {
  Chain chain;
  chain.run_up();
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    const MeanVector vector = chain.vectors.result(0, i).all;
    const auto expected = std::polar(kSignals[i].amplitude, kSignals[i].phase_rad);
    EXPECT_EQ(vector.count(), 187) << "all but the last few turns of 1500";
    std::printf("order %.4f: amplitude off by %+.5f %%, phase by %+.5f degrees\n", kSignals[i].order,
                100.0 * (std::abs(vector.mean() / expected) - 1.0),
                std::arg(vector.mean() / expected) / kDegree);
    // 2e-4 of the low-pass.
    EXPECT_NEAR(std::abs(vector.mean() / expected), 1.0, 3e-4) << kSignals[i].order;
    EXPECT_NEAR(std::arg(vector.mean() / expected), 0.0, 0.002 * kDegree) << kSignals[i].order;
  }
}

TEST(AnalyticOrders, VectorsKeepWithinTheirConfidenceUnderNoise) {
  Chain chain;
  chain.run_up(1.0, 0.1 * kDegree);
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    const MeanVector vector = chain.vectors.result(0, i).all;
    const auto confidence = vector.confidence();
    ASSERT_TRUE(confidence && confidence->phase_rad);
    const auto expected = std::polar(kSignals[i].amplitude, kSignals[i].phase_rad);
    EXPECT_LT(std::abs(std::abs(vector.mean()) - kSignals[i].amplitude), 1.5 * confidence->amplitude);
    EXPECT_LT(std::abs(std::arg(vector.mean() / expected)), 1.5 * *confidence->phase_rad);
    // 36 000 samples of noise 1: 2.45 sqrt(2 / 36000) = 0.018, more where slow turns have more samples each.
    EXPECT_GT(confidence->amplitude, 0.012);
    EXPECT_LT(confidence->amplitude, 0.04);
  }
}

}  // namespace
}  // namespace roadbalance
