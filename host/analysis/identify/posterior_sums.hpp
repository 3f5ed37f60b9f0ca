#pragma once

#include <map>
#include <vector>

#include "host/analysis/identify/line_moments.hpp"
#include "host/analysis/identify/section.hpp"
#include "host/analysis/identify/spectral_moments.hpp"

namespace roadbalance {

/// A drive's contribution to the posterior, by class of speed.  Memory is bounded by the speeds driven: 3 MB
/// each.
struct PosteriorSums {
  struct Speed {
    SpectralMoments spectra;
    LineMoments lines;
  };
  std::map<int, Speed> speed;  ///< by speed over the width of a class
  double cut_s = 0.0;          ///< left out for transients

  Speed& at(const DrivenSection& section, double class_width_m_s) {
    return speed[static_cast<int>(section.speed_seconds / section.seconds / class_width_m_s)];
  }
  void add(const DrivenSection& section, double class_width_m_s) {
    Speed& found = at(section, class_width_m_s);
    found.spectra += section.spectra;
    found.lines += section.lines;
    cut_s += section.cut_s;
  }
  PosteriorSums& operator+=(const PosteriorSums& other) {
    for (const auto& [key, each] : other.speed) {
      speed[key].spectra += each.spectra;
      speed[key].lines += each.lines;
    }
    cut_s += other.cut_s;
    return *this;
  }
  bool has_spectra() const {
    for (const auto& [key, each] : speed)
      if (each.spectra.segments > 0.0) return true;
    return false;
  }
};

/// Those of each speed.
inline std::vector<LineMoments> lines_of(const PosteriorSums& sums) {
  std::vector<LineMoments> all;
  for (const auto& [key, speed] : sums.speed)
    if (speed.lines.seconds > 0.0) all.push_back(speed.lines);
  return all;
}

}  // namespace roadbalance
