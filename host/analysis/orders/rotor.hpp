#pragma once

#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The body whose turns orders are counted by: a wheel, or what wheels turn at a fixed ratio (RotorConfig).
struct Rotor {
  std::string name;
  std::vector<int> wheel;  ///< places in VehicleConfig::wheel; the mean of their angles turns it
  double ratio = 1.0;
  /// Its angle is known modulo this share of its turn: 1 of a wheel with a zero mark, 1/q of what such wheels
  /// turn at p/q, 0 where no more is known than how far it has turned.
  double known_share = 1.0;

  double class_hz(const VehicleConfig& vehicle) const;  ///< width of a speed class, turns a second
  double way_m(const VehicleConfig& vehicle) const;     ///< of the car in a turn
};

Rotor rotor_of(const VehicleConfig& vehicle, const WheelConfig& wheel);
Rotor rotor_of(const VehicleConfig& vehicle, const RotorConfig& rotor);

/// The share of a turn that a rotor's angle is known modulo if `wheels` wheels, each known modulo a turn,
/// turn it by `ratio` times the mean of their angles: 1/q of ratio / wheels = p/q in lowest terms.
///
/// With two wheels and ratio 4: a turn of one wheel more or less is two turns of the rotor: all is known.
/// With ratio 41/11 and one wheel the rotor stands in one of 11 places, and only orders that are multiples
/// of 11 look alike in all of them.
/// @return 0 if no q up to kLargestDenominator gives the ratio within its nine digits
double known_share(double ratio, int wheels);
inline constexpr int kLargestDenominator = 1000;

}  // namespace roadbalance
