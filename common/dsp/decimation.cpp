#include "common/dsp/decimation.hpp"

#include <cassert>
#include <cmath>
#include <numbers>

namespace roadbalance {

Eigen::VectorXd decimation_taps(int factor) {
  assert(factor >= 1);
  if (factor == 1) return Eigen::VectorXd::Ones(1);
  const int half = 8 * factor;
  const double cutoff = 0.4 / factor;  // in units of the old rate
  constexpr double kBeta = 8.0;
  Eigen::VectorXd taps(2 * half + 1);
  for (int k = -half; k <= half; ++k) {
    const double x = 2.0 * std::numbers::pi * cutoff * k;
    const double position = static_cast<double>(k) / half;
    const double window = std::cyl_bessel_i(0.0, kBeta * std::sqrt(1.0 - position * position));
    taps(k + half) = window * (k == 0 ? 1.0 : std::sin(x) / x);
  }
  return taps / taps.sum();
}

}  // namespace roadbalance
