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
      lines_((static_cast<std::size_t>(fft_.bins()) + kBinsOfLane - 1) / kBinsOfLane * 2),
      sum_(lines_.size() / 2 * kBinsOfLane) {}

void WelchPsd::add(std::span<const double> samples) {
  while (!samples.empty()) {
    if (filled_ == 0 && samples.size() >= history_.size()) {  // it lies there whole
      add_segment(samples.data());
      samples = samples.subspan(hop_);
      continue;
    }
    const std::size_t taken = std::min(samples.size(), history_.size() - filled_);
    std::copy_n(samples.begin(), taken, history_.begin() + static_cast<std::ptrdiff_t>(filled_));
    samples = samples.subspan(taken);
    filled_ += taken;
    if (filled_ < history_.size()) continue;
    add_segment(history_.data());
    std::copy(history_.begin() + static_cast<std::ptrdiff_t>(hop_), history_.end(), history_.begin());
    filled_ -= hop_;
  }
}

void WelchPsd::add_segment(const double* segment) {
  const auto tapered = fft_.input();
  for (std::size_t n = 0; n < tapered.size(); ++n) tapered[n] = window_[n] * segment[n];
  fft_.transform(tapered, lines_);
  for (std::size_t lane = 0; lane < lines_.size(); lane += 2) {
    double* const sum = &sum_[lane / 2 * kBinsOfLane];
    const BinLane &re = lines_[lane], &im = lines_[lane + 1];
    for (int k = 0; k < kBinsOfLane; ++k) sum[k] += re.of[k] * re.of[k] + im.of[k] * im.of[k];
  }
  ++averages_;
}

void WelchPsd::reset() {
  filled_ = 0;
  averages_ = 0;
  std::fill(sum_.begin(), sum_.end(), 0.0);
}

std::vector<double> WelchPsd::density() const {
  std::vector<double> density(sum_.begin(), sum_.begin() + bins());
  if (averages_ == 0) return density;
  const double each = 2.0 * scale_ / averages_;
  for (double& of_bin : density) of_bin *= each;
  density.front() *= 0.5;  // its own mirror image, as is half the rate
  if (history_.size() % 2 == 0) density.back() *= 0.5;
  return density;
}

}  // namespace roadbalance
