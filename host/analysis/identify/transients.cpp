#include "host/analysis/identify/transients.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/dsp/linear_filter.hpp"
#include "common/dsp/state_filter.hpp"
#include "common/types/angle_units.hpp"

namespace roadbalance {
namespace {

constexpr double kHighPass_hz = 8.0;
constexpr double kMostSigmas = 5.0;
constexpr double kBefore_s = 0.25, kAfter_s = 0.8;
constexpr double kMedianOfNormal = 0.6745;  ///< of the size, in standard deviations

/// Behind a Butterworth high-pass of second order [channel x sample].
Eigen::MatrixXd high_passed(const Eigen::Ref<const Eigen::MatrixXd>& channels, double rate_hz) {
  const double corner = kTurn * kHighPass_hz;
  const Eigen::Vector2d denominator(corner * corner, std::sqrt(2.0) * corner);
  StateFilter filter(discretise_ramp_invariant(companion(denominator), 1.0 / rate_hz), channels.rows());
  Eigen::MatrixXd passed(channels.rows(), channels.cols());
  for (Eigen::Index t = 0; t < channels.cols(); ++t) {
    const auto state = filter.update(channels.col(t).array());
    passed.col(t) = channels.col(t).array() - denominator(0) * state.col(0) - denominator(1) * state.col(1);
  }
  return passed;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Eigen::ArrayXd quiet_samples(const Eigen::Ref<const Eigen::MatrixXd>& carriers, double rate_hz) {
  const Eigen::Index samples = carriers.cols();
  Eigen::ArrayXd quiet = Eigen::ArrayXd::Ones(samples);
  if (samples == 0) return quiet;
  const auto before = static_cast<Eigen::Index>(std::lround(kBefore_s * rate_hz));
  const auto after = static_cast<Eigen::Index>(std::lround(kAfter_s * rate_hz));
  const Eigen::MatrixXd passed = high_passed(carriers, rate_hz);
  for (Eigen::Index c = 0; c < passed.rows(); ++c) {
    std::vector<double> sizes(static_cast<std::size_t>(samples));
    for (Eigen::Index t = 0; t < samples; ++t) sizes[static_cast<std::size_t>(t)] = std::abs(passed(c, t));
    const double most = kMostSigmas * median(sizes) / kMedianOfNormal;
    for (Eigen::Index t = 0; t < samples; ++t) {
      if (sizes[static_cast<std::size_t>(t)] <= most) continue;
      const Eigen::Index from = std::max<Eigen::Index>(0, t - before);
      quiet.segment(from, std::min(samples, t + after) - from).setZero();
    }
  }
  return quiet;
}

}  // namespace roadbalance
