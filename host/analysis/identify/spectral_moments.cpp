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
/// Up to here a bin is one line of the transform; then they grow by octaves.  Determinants are taken in their
/// middle: with bins of 1 Hz at 12 Hz the wheels' hop seems by 20 N s/m too sharp.
constexpr double kFinest_hz = 8.0;
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
  const double step_hz = rate_hz / static_cast<double>(fft_.size());
  first_ = static_cast<Index>(std::ceil(kSpectraFrom_hz / step_hz - 1e-9));
  const auto last = static_cast<Index>(std::floor(kSpectraTo_hz / step_hz + 1e-9));
  std::vector<double> sum_hz, lines;
  double border_hz = 0.0;
  for (Index line = first_; line <= last; ++line) {
    const double line_hz = step_hz * static_cast<double>(line);
    if (line_hz > border_hz * (1.0 + 1e-9)) {
      const double octaves = std::floor(std::log2(line_hz * (1.0 - 1e-9) / kFinest_hz));
      const double width_hz = octaves < 0.0 ? step_hz : 2.0 * step_hz * std::exp2(octaves);
      border_hz = width_hz * std::ceil(line_hz / width_hz - 1e-9);
      sum_hz.push_back(0.0);
      lines.push_back(0.0);
    }
    bin_.push_back(std::ssize(sum_hz) - 1);
    sum_hz.back() += line_hz;
    lines.back() += 1.0;
  }
  frequency_hz_ = Eigen::Map<const Eigen::ArrayXd>(sum_hz.data(), std::ssize(sum_hz)) /
                  Eigen::Map<const Eigen::ArrayXd>(lines.data(), std::ssize(lines));
}

void SpectralGatherer::add(SpectralMoments& sum, const Eigen::Ref<const Eigen::MatrixXd>& motion,
                           double weight, const Eigen::Vector4d& omega, double speed_m_s) {
  if (sum.segments == 0.0) {
    sum.frequency_hz = frequency_hz_;
    sum.count.setZero(frequency_hz_.size());
    sum.same.assign(static_cast<std::size_t>(frequency_hz_.size()),
                    Eigen::MatrixXcd::Zero(motion.rows(), motion.rows()));
    sum.delayed = sum.same;
  }
  const double step_hz = rate_hz_ / static_cast<double>(fft_.size());
  const double delay_s = wheelbase_m_ / speed_m_s;
  const std::vector<bool> masked = bins_with_lines(bin_.size(), first_, step_hz, omega);
  const Eigen::MatrixXcd x = transformed(motion);
  for (std::size_t line = 0; line < bin_.size(); ++line) {
    if (masked[line]) continue;
    const auto b = static_cast<std::size_t>(bin_[line]);
    const auto column = x.col(static_cast<Index>(line));
    const double line_omega = kTurn * step_hz * static_cast<double>(first_ + static_cast<Index>(line));
    const Eigen::MatrixXcd product = weight * column * column.adjoint();
    sum.same[b] += product;
    sum.delayed[b] += std::polar(1.0, -line_omega * delay_s) * product;
    sum.count(bin_[line]) += weight;
  }
  sum.delay_seconds += weight * delay_s;
  sum.segments += weight;
}

/// [motion x line] under the window.
Eigen::MatrixXcd SpectralGatherer::transformed(const Eigen::Ref<const Eigen::MatrixXd>& motion) {
  std::vector<double> tapered(static_cast<std::size_t>(fft_.size()));
  std::vector<Complex> lines(static_cast<std::size_t>(fft_.bins()));
  Eigen::MatrixXcd x(motion.rows(), std::ssize(bin_));
  for (Index row = 0; row < motion.rows(); ++row) {
    Eigen::Map<Eigen::ArrayXd>(tapered.data(), window_.size()) =
        motion.row(row).transpose().array() * window_;
    fft_.forward(tapered, lines);
    for (Index k = 0; k < x.cols(); ++k) {
      // The integrals take the acceleration for straight lines between samples: sinc^2 of what it is.
      const double phase =
          std::numbers::pi * static_cast<double>(first_ + k) / static_cast<double>(fft_.size());
      const bool integrated = row >= channels_ && row < 3 * channels_;
      const double straight = integrated ? std::pow(std::sin(phase) / phase, 2) : 1.0;
      x(row, k) = lines[static_cast<std::size_t>(first_ + k)] / straight;
    }
  }
  return x;
}

}  // namespace roadbalance
