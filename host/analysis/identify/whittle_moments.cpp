#include "host/analysis/identify/whittle_moments.hpp"

#include <cmath>
#include <complex>

#include "common/dsp/window.hpp"
#include "common/types/angle_units.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;

}  // namespace

WhittleGatherer::WhittleGatherer(const Geometry& geometry, double rate_hz)
    : wheelbase_m_(geometry.x_m[0] - geometry.x_m[2]),
      rate_hz_(rate_hz),
      fft_(static_cast<int>(std::lround(kWhittleSegment_s * rate_hz))) {
  const std::vector<double> hann = window(Window::kHann, fft_.size());
  window_ = Eigen::Map<const Eigen::ArrayXd>(hann.data(), fft_.size());
}

WhittleMoments WhittleGatherer::moments(const Eigen::Ref<const SignalMatrix>& signals,
                                        const Eigen::Vector4d& omega, double speed_m_s) {
  WhittleMoments sum;
  const Eigen::Index size = fft_.size();
  if (signals.cols() < size) return sum;
  const double step_hz = rate_hz_ / static_cast<double>(size);
  first_ = static_cast<Eigen::Index>(std::ceil(kWhittleFrom_hz / step_hz - 1e-9));
  const auto last = static_cast<Eigen::Index>(std::floor(kWhittleTo_hz / step_hz + 1e-9));
  const auto bins = static_cast<std::size_t>(last - first_ + 1);
  sum.frequency_hz = step_hz * Eigen::ArrayXd::LinSpaced(last - first_ + 1, static_cast<double>(first_),
                                                         static_cast<double>(last));
  sum.count.setZero(static_cast<Eigen::Index>(bins));
  sum.same.assign(bins, WhittleMoments::Spectra::value_type::Zero());
  sum.delayed = sum.same;
  masked_ = bins_with_lines(bins, first_, step_hz, omega);
  const HannSegments segments = HannSegments::over(signals.cols(), size);
  weight_ = segments.weight;
  for (const Eigen::Index begin : segments.begin)
    add_segment(sum, signals.middleCols(begin, size), wheelbase_m_ / speed_m_s);
  return sum;
}

void WhittleGatherer::add_segment(WhittleMoments& sum, const Eigen::Ref<const SignalMatrix>& signals,
                                  double delay_s) {
  std::vector<double> tapered(static_cast<std::size_t>(fft_.size()));
  std::vector<Complex> lines(static_cast<std::size_t>(fft_.bins()));
  const auto bins = static_cast<Eigen::Index>(sum.same.size());
  Eigen::Matrix<Complex, kCoordinates, Eigen::Dynamic> Z(kCoordinates, bins);
  for (int c = 0; c < kCoordinates; ++c) {
    Eigen::Map<Eigen::ArrayXd>(tapered.data(), window_.size()) = signals.row(c).transpose().array() * window_;
    fft_.forward(tapered, lines);
    for (Eigen::Index k = 0; k < bins; ++k) Z(c, k) = lines[static_cast<std::size_t>(first_ + k)];
  }
  for (Eigen::Index k = 0; k < bins; ++k) {
    const auto b = static_cast<std::size_t>(k);
    if (masked_[b]) continue;
    const auto product = (weight_ * Z.col(k) * Z.col(k).adjoint()).eval();
    sum.same[b] += product;
    sum.delayed[b] += std::polar(1.0, -sum.omega(k) * delay_s) * product;
    sum.count(k) += weight_;
  }
  sum.delay_seconds += weight_ * delay_s;
  sum.segments += weight_;
}

}  // namespace roadbalance
