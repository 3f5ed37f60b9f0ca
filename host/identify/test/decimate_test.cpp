#include "host/identify/decimate.hpp"

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

}  // namespace
}  // namespace roadbalance
