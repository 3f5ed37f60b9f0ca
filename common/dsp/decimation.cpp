#include "common/dsp/decimation.hpp"

#include <cassert>
#include <cmath>
#include <numbers>

namespace roadbalance {

namespace {

/// Sinc of the cut-off under a Kaiser window of `half` old samples to each side; in units of the old rate.
Eigen::VectorXd low_pass(int half, double cutoff, double beta) {
  Eigen::VectorXd taps(2 * half + 1);
  for (int k = -half; k <= half; ++k) {
    const double x = 2.0 * std::numbers::pi * cutoff * k;
    const double position = static_cast<double>(k) / half;
    const double window = std::cyl_bessel_i(0.0, beta * std::sqrt(1.0 - position * position));
    taps(k + half) = window * (k == 0 ? 1.0 : std::sin(x) / x);
  }
  return taps / taps.sum();
}

}  // namespace

Eigen::VectorXd decimation_taps(int factor) {
  assert(factor >= 1);
  return factor == 1 ? Eigen::VectorXd::Ones(1) : low_pass(8 * factor, 0.4 / factor, 8.0);
}

Eigen::VectorXd reduction_taps(int factor) {
  assert(factor >= 1);
  return factor == 1 ? Eigen::VectorXd::Ones(1) : low_pass(kReductionHalf * factor, 0.45 / factor, 10.1);
}

}  // namespace roadbalance
