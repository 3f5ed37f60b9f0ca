#include "common/dsp/fractional_delay.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace roadbalance {
namespace {

/// Response at `frequency` of the sample rate, against that of a pure delay.
std::complex<double> against_a_pure_delay(const FractionalDelay& delay, double fraction, double frequency) {
  const auto taps = delay.taps(fraction);
  std::complex<double> sum = 0.0;
  for (int k = 0; k < FractionalDelay::kTaps; ++k)
    sum += taps(k) *
           std::polar(1.0, 2.0 * std::numbers::pi * frequency * (k - FractionalDelay::kBefore - fraction));
  return sum;
}

constexpr double kDegrees = 180.0 / std::numbers::pi;

TEST(FractionalDelay, IsAPureDelayWhereSignalsAre) {
  const FractionalDelay delay;
  double worst_phase_deg = 0.0, worst_gain = 0.0, worst_at_25_hz_deg = 0.0;
  for (double fraction = 0.0; fraction <= 1.0; fraction += 0.0007) {  // between the table's entries, too
    for (double frequency = 0.0; frequency <= 0.38; frequency += 0.01) {
      const auto response = against_a_pure_delay(delay, fraction, frequency);
      worst_phase_deg = std::max(worst_phase_deg, std::abs(std::arg(response)) * kDegrees);
      worst_gain = std::max(worst_gain, std::abs(std::abs(response) - 1.0));
    }
    for (const double rate_hz : {500.0, 2000.0})
      worst_at_25_hz_deg =
          std::max(worst_at_25_hz_deg,
                   std::abs(std::arg(against_a_pure_delay(delay, fraction, 25.0 / rate_hz))) * kDegrees);
  }
  EXPECT_LT(worst_phase_deg, 0.001);
  EXPECT_LT(worst_gain, 3e-5);
  EXPECT_LT(worst_at_25_hz_deg, 0.0005);  // a twentieth of what is allowed
}

TEST(FractionalDelay, FractionsZeroAndOneAreTheSamplesThemselves) {
  const FractionalDelay delay;
  for (int k = 0; k < FractionalDelay::kTaps; ++k) {
    EXPECT_NEAR(delay.taps(0.0)(k), k == FractionalDelay::kBefore ? 1.0 : 0.0, 1e-15);
    EXPECT_NEAR(delay.taps(1.0)(k), k == FractionalDelay::kBefore + 1 ? 1.0 : 0.0, 1e-15);
  }
}

TEST(FractionalDelay, KeepsAConstant) {
  const FractionalDelay delay;
  for (double fraction = 0.0; fraction <= 1.0; fraction += 0.003)
    EXPECT_NEAR(delay.taps(fraction).sum(), 1.0, 1e-14);
}

// Fused, a product and a sum are rounded once, and only processors that can do so would.
TEST(FractionalDelay, RoundsEachProductAndTheirSum) {
  const FractionalDelay delay;
  constexpr double kPart = 0.3125, kStep = 1.0 / 256.0;  // exact, and so is the place between two columns
  for (int f = 0; f < 256; ++f) {
    const auto below = delay.taps(f * kStep), above = delay.taps((f + 1) * kStep);
    const auto between = delay.taps((f + kPart) * kStep);
    for (int k = 0; k < FractionalDelay::kTaps; ++k) {
      const volatile double one = (1.0 - kPart) * below(k), other = kPart * above(k);
      EXPECT_EQ(between(k), one + other) << f << ' ' << k;
    }
  }
}

}  // namespace
}  // namespace roadbalance
