#include "common/dsp/psd.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace roadbalance {
namespace {

const WelchPsd::Settings& checked(const WelchPsd::Settings& settings) {
  if (!(settings.rate_hz > 0.0)) throw std::invalid_argument("PSD sampling rate must be positive");
  if (settings.segment < 2) throw std::invalid_argument("PSD segment must have at least 2 samples");
  if (!(settings.overlap >= 0.0 && settings.overlap < 1.0))
    throw std::invalid_argument("PSD overlap must be 0 <= overlap < 1");
  return settings;
}

}  // namespace

WelchPsd::WelchPsd(const Settings& settings)
    : fft_(checked(settings).segment),
      window_(window(settings.window, settings.segment)),
      hop_(static_cast<std::size_t>(std::max(1.0, std::round((1.0 - settings.overlap) * settings.segment)))),
      step_hz_(settings.rate_hz / settings.segment),
      enbw_hz_(equivalent_noise_bandwidth_bins(window_) * step_hz_),
      scale_(1.0 /
             (settings.rate_hz * std::inner_product(window_.begin(), window_.end(), window_.begin(), 0.0))),
      history_(window_.size()),
      tapered_(window_.size()),
      lines_(static_cast<std::size_t>(fft_.bins())),
      sum_(lines_.size()) {}

void WelchPsd::add(std::span<const double> samples) {
  while (!samples.empty()) {
    const std::size_t taken = std::min(samples.size(), history_.size() - filled_);
    std::copy_n(samples.begin(), taken, history_.begin() + static_cast<std::ptrdiff_t>(filled_));
    samples = samples.subspan(taken);
    filled_ += taken;
    if (filled_ == history_.size()) add_segment();
  }
}

void WelchPsd::add_segment() {
  for (std::size_t n = 0; n < tapered_.size(); ++n) tapered_[n] = window_[n] * history_[n];
  fft_.forward(tapered_, lines_);
  for (std::size_t k = 0; k < lines_.size(); ++k) sum_[k] += std::norm(lines_[k]);
  ++averages_;
  std::copy(history_.begin() + static_cast<std::ptrdiff_t>(hop_), history_.end(), history_.begin());
  filled_ -= hop_;
}

void WelchPsd::reset() {
  filled_ = 0;
  averages_ = 0;
  std::fill(sum_.begin(), sum_.end(), 0.0);
}

std::vector<double> WelchPsd::density() const {
  std::vector<double> density(sum_.size(), 0.0);
  if (averages_ == 0) return density;
  for (std::size_t k = 0; k < density.size(); ++k) {
    const bool alone = k == 0 || (2 * k == history_.size());  // its own mirror image
    density[k] = (alone ? 1.0 : 2.0) * scale_ * sum_[k] / averages_;
  }
  return density;
}

}  // namespace roadbalance
