#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "common/dsp/cross_spectra.hpp"

namespace roadbalance {

/// The bins of a spectrum that a display gets: those up to a frequency, of too many neighbours as one, so
/// that densities keep their integral.
class ShownBins {
 public:
  ShownBins(const CrossSpectra& spectra, double highest_hz, std::size_t most)
      : step_hz_(spectra.step_hz()), enbw_hz_(spectra.enbw_hz()) {
    const double highest = std::floor(highest_hz / step_hz_ + 1e-9) + 1.0;
    bins_ = static_cast<std::size_t>(std::min(highest, static_cast<double>(spectra.bins())));
    merged_ = (bins_ + most - 1) / most;
  }

  std::size_t count() const { return bins_ / merged_; }
  double step_hz() const { return static_cast<double>(merged_) * step_hz_; }
  /// The middle of those that are shown as one.
  double hz(std::size_t shown) const {
    return (static_cast<double>(shown) + 0.5 * (1.0 - 1.0 / static_cast<double>(merged_))) * step_hz();
  }
  /// How many bins that scatter by themselves one is worth: those of a window wider than one share their
  /// values.
  double worth() const {
    return std::max(1.0, static_cast<double>(merged_) / std::max(1.0, enbw_hz_ / step_hz_));
  }
  double enbw_hz() const { return enbw_hz_ * worth(); }

  /// @param bins  [bin] of the spectrum
  template <typename T>
  std::vector<T> of(const std::vector<T>& bins) const {
    std::vector<T> shown(count());
    const double share = 1.0 / static_cast<double>(merged_);
    for (std::size_t k = 0; k < merged_ * shown.size(); ++k) shown[k / merged_] += share * bins[k];
    return shown;
  }

 private:
  double step_hz_, enbw_hz_;
  std::size_t bins_ = 0, merged_ = 1;
};

}  // namespace roadbalance
