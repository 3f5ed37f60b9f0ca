#pragma once

#include <complex>
#include <cstddef>
#include <vector>

namespace roadbalance {

/// What weights there are to clip or stick on a wheel, and where.
struct WeightStock {
  double step_g = 5.0;       ///< masses are multiples of this; 7.0874 g is a quarter of an ounce
  double heaviest_g = 60.0;  ///< in one place
  int most = 2;              ///< weights on a wheel, 1 or 2
  /// Radii of the places: inner and outer rim flange, or where adhesive weights are stuck.
  std::vector<double> radius_m{};
  double raster_rad = 0.0;         ///< angle between places, counted from the zero mark; 0: anywhere
  double length_m_per_g = 2.5e-3;  ///< of a weight along the rim: two do not lie on one another
};

/// A weight on a wheel; angle from the zero mark in the direction of rotation.
struct WheelWeight {
  double mass_g = 0.0;
  double angle_rad = 0.0;
  double radius_m = 0.0;

  /// Mass times radius at its angle, g m.
  std::complex<double> moment_g_m() const { return std::polar(mass_g * radius_m, angle_rad); }
};

inline constexpr std::size_t kMostFittedWeights = 8;  ///< on a wheel
inline constexpr std::size_t kMostRadii = 4;

}  // namespace roadbalance
