#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace roadbalance {

/// How a weight holds on the rim.
enum class WeightKind : std::int32_t { kNotGiven = 0, kClip = 1, kAdhesive = 2 };

/// Which side of the wheel it is on: towards the car, or away from it.
enum class RimPlane : std::int32_t { kNotGiven = 0, kInner = 1, kOuter = 2 };

/// A circle of the rim on which weights go; [[wheel.place]].
struct WeightPlace {
  double radius_m = 0.0;
  WeightKind kind = WeightKind::kNotGiven;
  RimPlane plane = RimPlane::kNotGiven;

  bool operator==(const WeightPlace&) const = default;
};

/// The weights there are to clip or stick on a wheel, and where.
struct WeightStock {
  double step_g = 5.0;               ///< masses are multiples of this; 7.0874 g is a quarter of an ounce
  double heaviest_g = 60.0;          ///< in one place
  int most = 2;                      ///< weights on a wheel, 1 or 2
  std::vector<WeightPlace> place{};  ///< in the order in which they are wanted
  double raster_rad = 0.0;           ///< angle between places, counted from the reference point; 0: anywhere
  double length_m_per_g = 2.5e-3;    ///< of a weight along the rim: two do not lie on one another
};

/// A weight on a wheel; angle from the reference point in the direction of rotation.
struct WheelWeight {
  double mass_g = 0.0;
  double angle_rad = 0.0;
  WeightPlace place{};

  double amount_g_m() const { return mass_g * place.radius_m; }
  /// Mass times radius at its angle, g m: the static unbalance that it is, in whatever plane.
  std::complex<double> moment_g_m() const { return std::polar(amount_g_m(), angle_rad); }
};

inline constexpr std::size_t kMostFittedWeights = 8;  ///< on a wheel
inline constexpr std::size_t kMostPlaces = 4;

}  // namespace roadbalance
