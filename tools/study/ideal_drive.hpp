#pragma once

#include <cstdint>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/identify/stretch.hpp"
#include "sim/scenario.hpp"

namespace roadbalance {

/// A drive of the simulated car as estimators would see it behind perfect sensors and encoders: exact
/// accelerations of the seven coordinates, exact wheel angles.
struct IdealDrive {
  sim::Scenario scenario;          ///< its road, wheels and spreads; not its drive, sensors, encoders
  std::vector<double> speeds_m_s;  ///< one plateau each, without wander
  Eigen::Index samples = 20000;    ///< of each plateau, at rate_hz
  double rate_hz = 500.0;
  bool road_measured = false;  ///< give the exact road under the wheels, too
  /// The wheels' angles are drawn anew for each speed, and with them the road that follows: as if each were
  /// driven another time.
  bool angles_drawn_at_each_speed = false;
};

/// One stretch for each speed, in this order.
///
/// The car is stepped at four times rate_hz and brought to rate_hz by the filter that the identification
/// uses; speed changes and 3 s after each are left out.  All stretches are of one car and, unless angles are
/// drawn at each speed, one road.
///
/// @throws std::invalid_argument if angles are drawn at each speed of a scenario whose parameters or rolling
///     radii are drawn, too: each speed would be of another car
std::vector<Stretch> drive_ideally(const IdealDrive& drive, std::uint64_t seed, const VehicleConfig& vehicle);

}  // namespace roadbalance
