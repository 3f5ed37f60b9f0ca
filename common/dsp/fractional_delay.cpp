#include "common/dsp/fractional_delay.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roadbalance {
namespace {

constexpr double kBeta = 10.0;

double kaiser_sinc(double at) {
  const double position = at / (0.5 * FractionalDelay::kTaps);
  if (std::abs(position) >= 1.0) return 0.0;
  const double window = std::cyl_bessel_i(0.0, kBeta * std::sqrt(1.0 - position * position));
  const double x = std::numbers::pi * at;
  return window * (std::abs(x) < 1e-9 ? 1.0 : std::sin(x) / x);
}

}  // namespace

FractionalDelay::FractionalDelay() {
  for (int f = 0; f <= kFractions; ++f) {
    const double fraction = static_cast<double>(f) / kFractions;
    for (int k = 0; k < kTaps; ++k) table_(k, f) = kaiser_sinc(k - kBefore - fraction);
    table_.col(f) /= table_.col(f).sum();
  }
}

FractionalDelay::Taps FractionalDelay::taps(double fraction) const {
  const double place = std::clamp(fraction, 0.0, 1.0) * kFractions;
  const int below = std::min(static_cast<int>(place), kFractions - 1);
  const double part = place - below;
  return (1.0 - part) * table_.col(below) + part * table_.col(below + 1);
}

}  // namespace roadbalance
