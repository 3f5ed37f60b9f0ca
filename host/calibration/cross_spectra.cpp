#include "host/calibration/cross_spectra.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/dsp/window.hpp"

namespace roadbalance {

CrossSpectra::CrossSpectra(const Settings& settings)
    : fft_(std::max(2, static_cast<int>(std::lround(settings.segment_s * settings.rate_hz)))),
      step_hz_(settings.rate_hz / fft_.size()),
      window_(window(Window::kHann, fft_.size())),
      tapered_(window_.size()),
      lines_(static_cast<std::size_t>(fft_.bins())),
      history_(fft_.size(), settings.channels) {
  const auto last = static_cast<std::int64_t>(
      std::min(std::floor(settings.high_hz / step_hz_), static_cast<double>(fft_.bins() - 1)));
  const auto first = static_cast<std::int64_t>(std::ceil(settings.low_hz / step_hz_));
  if (first < 1 || last < first) throw std::invalid_argument("cross spectra: no bin lies within the band");
  first_bin_ = static_cast<std::size_t>(first);
  sum_.assign(static_cast<std::size_t>(last - first + 1),
              Eigen::MatrixXcd::Zero(settings.channels, settings.channels));
  at_bins_.resize(settings.channels, std::ssize(sum_));
}

void CrossSpectra::add(std::span<const double> sample) {
  history_.row(filled_++) = Eigen::Map<const Eigen::RowVectorXd>(sample.data(), std::ssize(sample));
  if (filled_ == history_.rows()) add_segment();
}

void CrossSpectra::add_segment() {
  for (Eigen::Index c = 0; c < history_.cols(); ++c) {
    const double mean = history_.col(c).mean();  // of rest; it would leak into the lowest bins
    for (std::size_t n = 0; n < tapered_.size(); ++n)
      tapered_[n] = window_[n] * (history_(static_cast<Eigen::Index>(n), c) - mean);
    fft_.forward(tapered_, lines_);
    for (std::size_t k = 0; k < sum_.size(); ++k)
      at_bins_(c, static_cast<Eigen::Index>(k)) = lines_[first_bin_ + k];
  }
  for (std::size_t k = 0; k < sum_.size(); ++k) {
    const auto x = at_bins_.col(static_cast<Eigen::Index>(k));
    sum_[k] += x.conjugate() * x.transpose();
  }
  ++averages_;
  const Eigen::Index hop = history_.rows() / 2, kept = history_.rows() - hop;
  history_.topRows(kept) = history_.bottomRows(kept).eval();
  filled_ = kept;
}

}  // namespace roadbalance
