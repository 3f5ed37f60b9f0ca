#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace roadbalance {

/// A line that stands out of a spectrum.
struct SpectrumPeak {
  std::size_t bin;
  double prominence;  ///< how many times as high as what lies between it and the next higher one
};

/// The highest bins that stand out of an averaged density, the most prominent first: topographic prominence,
/// here as a ratio, of at least four and of more than chance makes: the mean of n independent segments
/// scatters by 1 / sqrt(n) of itself, and peak and valley by four times that each.  None if n < 8.
///
/// Source: prominence as in SciPy's signal.peak_prominences; scatter of Welch's mean: P. Welch, IEEE Trans.
/// Audio Electroacoust. 15 (1967) 70.
/// @param first     bin; those below are not looked at
/// @param averages  n, >= 1
/// @param most      peaks
std::vector<SpectrumPeak> spectrum_peaks(const std::vector<double>& density, std::size_t first,
                                         double averages, std::size_t most);

/// SVG of a one-sided density over frequency, both logarithmic, from 0.5 Hz to half the rate.  Where bins
/// fall on one another, the highest is drawn; peaks are marked with their frequency.
/// @param density  [bins]
std::string spectrum_chart(const std::vector<double>& density, double step_hz, double averages);

}  // namespace roadbalance
