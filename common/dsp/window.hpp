#pragma once

#include <span>
#include <vector>

namespace roadbalance {

enum class Window {
  kRectangular,
  kHann,     ///< for noise and closely spaced lines
  kFlatTop,  ///< for the height of a line: right within 0.0044 dB wherever it falls between bins
};

/// Samples of a window for spectra: periodic, so that a sine on a bin stays within the window's own bins.
///
///     w[n] = sum over k of (-1)^k a[k] cos(2 pi k n / size)
///
/// Source of the flat top: HFT95 in G. Heinzel, A. Ruediger, R. Schilling, Spectrum and spectral density
/// estimation by the DFT, 2002, appendix D.
///
/// @param size  >= 1
/// @throws std::invalid_argument
std::vector<double> window(Window kind, int size);

/// Width in bins of the rectangular filter that passes the same white noise: size sum(w^2) / sum(w)^2.
double equivalent_noise_bandwidth_bins(std::span<const double> window);

}  // namespace roadbalance
