#include "firmware/backends/replay/lateness.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace roadbalance {

void Lateness::add(std::chrono::nanoseconds late) noexcept {
  const double ns = std::max(0.0, static_cast<double>(late.count()));
  const double octaves = ns > kFirst_ns ? std::log2(ns / kFirst_ns) : 0.0;
  const auto bin = static_cast<std::size_t>(std::ceil(octaves * kBinsPerOctave));
  ++bin_[std::min(bin, kBins - 1)];
  ++events_;
  sum_ns_ += ns;
  most_ns_ = std::max(most_ns_, ns);
}

double Lateness::mean_ms() const {
  return events_ > 0 ? 1e-6 * sum_ns_ / static_cast<double>(events_) : 0.0;
}

double Lateness::within_ms(double share) const {
  std::int64_t so_far = 0;
  for (std::size_t k = 0; k < kBins; ++k) {
    so_far += bin_[k];
    if (so_far > 0 && static_cast<double>(so_far) >= share * static_cast<double>(events_))
      return std::min(1e-6 * kFirst_ns * std::exp2(static_cast<double>(k) / kBinsPerOctave), most_ms());
  }
  return most_ms();
}

std::string Lateness::sentence() const {
  char text[160];
  std::snprintf(text, sizeof text,
                "%lld runs of scans: %.2f ms late in the mean, %.2f ms in 99 %%, %.2f ms at most",
                static_cast<long long>(events_), mean_ms(), within_ms(0.99), most_ms());
  return text;
}

}  // namespace roadbalance
