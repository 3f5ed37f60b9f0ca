#include "host/analysis/identify/decimate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace roadbalance {
namespace {

constexpr double kGridHz = 2000.0;
constexpr int kFactor = 4;

/// Decimates e^{j 2 pi f t} (rows 0 and 1) and returns output / input at the output instants.
std::vector<std::complex<double>> gain_at(double frequency_hz, int samples) {
  std::vector<std::complex<double>> gains;
  std::int64_t index = 0;
  Decimator decimator(kFactor, [&](const IdentificationSample& sample) {
    // Output lies on multiples of the factor; the first one has half a filter, 32 samples, on each side.
    const double t = static_cast<double>(32 + kFactor * index++) / kGridHz;
    const double angle = 2.0 * std::numbers::pi * frequency_hz * t;
    gains.push_back(std::complex<double>(sample.signals(0), sample.signals(1)) * std::polar(1.0, -angle));
  });
  SignalRun run;
  run.restart = true;
  run.samples.setZero(kSignals, samples);
  for (int k = 0; k < samples; ++k) {
    const double angle = 2.0 * std::numbers::pi * frequency_hz * k / kGridHz;
    run.samples(0, k) = std::cos(angle);
    run.samples(1, k) = std::sin(angle);
  }
  decimator.consume(run);
  return gains;
}

TEST(Decimator, KeepsTheBandWithoutDelayOrLoss) {
  for (const double f : {1.0, 18.0, 60.0, 100.0})
    for (const auto& gain : gain_at(f, 2000)) EXPECT_LT(std::abs(gain - 1.0), 1e-3) << f;
}

TEST(Decimator, RemovesWhatWouldFold) {
  // A Kaiser window of beta 8 has side lobes of -81 dB; the stop band begins at 0.4 * 500 + 5.1 * 2000 / (2 *
  // 64) / 2 Hz.
  for (const double f : {330.0, 482.0, 518.0, 900.0})
    for (const auto& gain : gain_at(f, 2000)) EXPECT_LT(std::abs(gain), 3e-4) << f;
}

TEST(Decimator, ForgetsWhatLiesBeforeAGap) {
  std::vector<IdentificationSample> samples;
  Decimator decimator(kFactor, [&](const IdentificationSample& sample) { samples.push_back(sample); });
  SignalRun run;
  run.restart = true;
  run.samples = SignalMatrix::Constant(kSignals, 100, 1e6);
  decimator.consume(run);
  const std::size_t before = samples.size();
  run.first_index = 1000;
  run.samples = SignalMatrix::Ones(kSignals, 100);
  decimator.consume(run);
  ASSERT_GT(samples.size(), before);
  EXPECT_TRUE(samples[before].restart);
  for (std::size_t i = before; i < samples.size(); ++i) {
    EXPECT_NEAR(samples[i].signals(3), 1.0, 1e-12);
    EXPECT_EQ(samples[i].restart, i == before);
  }
}

// Runs of any length, from any index on: outputs lie at multiples of the factor, of all that each is made of.
TEST(Decimator, GoesOnFromRunToRunOnTheGrid) {
  std::vector<IdentificationSample> samples;
  Decimator decimator(kFactor, [&](const IdentificationSample& sample) { samples.push_back(sample); });
  constexpr std::int64_t kFirst = 1002;
  std::int64_t index = kFirst;
  for (const Eigen::Index rows : {1, 7, 64, 3, 50, 75}) {
    SignalRun run;
    run.restart = index == kFirst;
    run.first_index = index;
    run.samples.resize(kSignals, rows);
    run.road_m.resize(kWheels, rows);
    for (Eigen::Index r = 0; r < rows; ++r) {
      run.samples.col(r).setConstant(static_cast<double>(index));
      run.road_m.col(r).setConstant(-static_cast<double>(index++));
    }
    decimator.consume(run);
  }
  // 65 taps, of which the last is at 1068, 1072 .. 1200; what rises evenly passes as it is, 32 samples late.
  ASSERT_EQ(samples.size(), 34U);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double centre = 1068.0 - 32.0 + 4.0 * static_cast<double>(k);
    EXPECT_NEAR(samples[k].signals(5), centre, 1e-9);
    ASSERT_TRUE(samples[k].road_m);
    EXPECT_NEAR((*samples[k].road_m)(2), -centre, 1e-9);
    EXPECT_EQ(samples[k].restart, k == 0);
  }
}

TEST(Decimator, HasNoRoadMadeOfSamplesThatWereNotMeasured) {
  std::vector<IdentificationSample> samples;
  Decimator decimator(kFactor, [&](const IdentificationSample& sample) { samples.push_back(sample); });
  SignalRun run;
  run.restart = true;
  run.samples = SignalMatrix::Ones(kSignals, 200);
  for (const bool measured : {false, true}) {
    run.road_m = RoadMatrix::Ones(kWheels, measured ? 200 : 0);
    decimator.consume(run);
    run.restart = false;
    run.first_index += 200;
  }
  ASSERT_EQ(samples.size(), 84U);  // 64, 68 .. 396
  for (std::size_t k = 0; k < samples.size(); ++k)
    EXPECT_EQ(samples[k].road_m.has_value(), k >= 50) << k;  // 264
}

}  // namespace
}  // namespace roadbalance
