#include "host/analysis/identify/spectral_moments.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include "common/dsp/linear_filter.hpp"
#include "common/dsp/window.hpp"
#include "common/types/angle_units.hpp"
#include "host/analysis/identify/hann_segments.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;

constexpr double kSpectraFrom_hz = 0.75, kSpectraTo_hz = 40.0;  ///< below the tyre's belt
constexpr double kSpectraSegment_s = 4.0;
constexpr double kMotionHighPass_hz = 0.35;
/// Coefficients of the Butterworth polynomial of third order: s^3 + d2 s^2 + d1 s + d0.
Eigen::Array3d high_pass() {
  const double corner = kTurn * kMotionHighPass_hz;
  return {corner * corner * corner, 2.0 * corner * corner, 2.0 * corner};
}

}  // namespace

MotionIntegrals::MotionIntegrals(Index channels, Index further, double rate_hz)
    : channels_(channels),
      denominator_(high_pass()),
      filter_(discretise_ramp_invariant(companion(denominator_.matrix()), 1.0 / rate_hz),
              channels + further) {}

void MotionIntegrals::update(const Eigen::Ref<const Eigen::ArrayXd>& signals,
                             Eigen::Ref<Eigen::ArrayXd> motion) {
  const Index further = signals.size() - channels_;
  // State k is s^k / D(s) of a signal.
  const auto state = filter_.update(signals);
  const auto passed = [&](Index first, Index count) {
    const auto of = state.middleRows(first, count);
    return signals.segment(first, count) - denominator_(0) * of.col(0) - denominator_(1) * of.col(1) -
           denominator_(2) * of.col(2);
  };
  motion.head(channels_) = passed(0, channels_);
  motion.segment(channels_, channels_) = state.col(2).head(channels_);
  motion.segment(2 * channels_, channels_) = state.col(1).head(channels_);
  motion.tail(further) = passed(channels_, further);
}

SpectralGatherer::SpectralGatherer(Index channels, double wheelbase_m, double rate_hz)
    : channels_(channels),
      wheelbase_m_(wheelbase_m),
      rate_hz_(rate_hz),
      fft_(static_cast<int>(std::lround(kSpectraSegment_s * rate_hz))) {
  const std::vector<double> hann = window(Window::kHann, fft_.size());
  window_ = Eigen::Map<const Eigen::ArrayXd>(hann.data(), fft_.size());
  window_ /= std::sqrt(window_.square().sum() * rate_hz);
}

SpectralMoments SpectralGatherer::moments(const Eigen::Ref<const Eigen::MatrixXd>& motion,
                                          const Eigen::Ref<const Eigen::ArrayXd>& distance_m,
                                          const Eigen::Ref<const Eigen::ArrayXd>& quiet,
                                          const Eigen::Vector4d& omega) {
  SpectralMoments sum;
  const Index size = fft_.size();
  if (motion.cols() < size) return sum;
  sum.step_hz = rate_hz_ / static_cast<double>(size);
  sum.first = static_cast<Index>(std::ceil(kSpectraFrom_hz / sum.step_hz - 1e-9));
  const auto last = static_cast<Index>(std::floor(kSpectraTo_hz / sum.step_hz + 1e-9));
  const auto bins = static_cast<std::size_t>(last - sum.first + 1);
  sum.count.setZero(static_cast<Index>(bins));
  sum.same.assign(bins, Eigen::MatrixXcd::Zero(motion.rows(), motion.rows()));
  sum.delayed = sum.same;
  const std::vector<bool> masked = bins_with_lines(bins, sum.first, sum.step_hz, omega);
  const HannSegments segments = HannSegments::over(motion.cols(), size);
  for (const Index begin : segments.begin) {
    if ((quiet.segment(begin, size) == 0.0).any()) continue;
    const double speed_m_s =
        (distance_m(begin + size - 1) - distance_m(begin)) * rate_hz_ / static_cast<double>(size - 1);
    add_segment(sum, motion.middleCols(begin, size), masked, segments.weight, wheelbase_m_ / speed_m_s);
  }
  return sum;
}

void SpectralGatherer::add_segment(SpectralMoments& sum, const Eigen::Ref<const Eigen::MatrixXd>& motion,
                                   const std::vector<bool>& masked, double weight, double delay_s) {
  std::vector<double> tapered(static_cast<std::size_t>(fft_.size()));
  std::vector<Complex> lines(static_cast<std::size_t>(fft_.bins()));
  const Index bins = sum.bins();
  Eigen::MatrixXcd x(motion.rows(), bins);
  for (Index row = 0; row < motion.rows(); ++row) {
    Eigen::Map<Eigen::ArrayXd>(tapered.data(), window_.size()) =
        motion.row(row).transpose().array() * window_;
    fft_.forward(tapered, lines);
    for (Index k = 0; k < bins; ++k) {
      // The integrals take the acceleration for straight lines between samples: sinc^2 of what it is.
      const double phase = 0.5 * sum.omega(k) / rate_hz_;
      const bool integrated = row >= channels_ && row < 3 * channels_;
      const double straight = integrated ? std::pow(std::sin(phase) / phase, 2) : 1.0;
      x(row, k) = lines[static_cast<std::size_t>(sum.first + k)] / straight;
    }
  }
  for (Index k = 0; k < bins; ++k) {
    const auto b = static_cast<std::size_t>(k);
    if (masked[b]) continue;
    const Eigen::MatrixXcd product = weight * x.col(k) * x.col(k).adjoint();
    sum.same[b] += product;
    sum.delayed[b] += std::polar(1.0, -sum.omega(k) * delay_s) * product;
    sum.count(k) += weight;
  }
  sum.delay_seconds += weight * delay_s;
  sum.segments += weight;
}

}  // namespace roadbalance
