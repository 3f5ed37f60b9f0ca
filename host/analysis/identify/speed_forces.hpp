#pragma once

#include <array>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/estimate_covariance.hpp"
#include "host/analysis/identify/first_order.hpp"

namespace roadbalance {

/// First-order forces on the wheels at one class of speed.
struct SpeedForces {
  double speed_m_s;
  double seconds;                              ///< driven so fast
  std::array<FirstOrderForce, kWheels> wheel;  ///< without a force the variance is 0
};

/// First-order forces of a car's wheels at the speeds of a drive.
struct DriveForces {
  ParameterVector parameters;      ///< the car's, suspension and tyres as identified
  std::vector<SpeedForces> speed;  ///< slowest first; empty: nothing is known
};

/// @param classes  of speed, as they were driven
/// @param x        the estimate from them
DriveForces drive_forces(const std::vector<DriveMoments>& classes, const UnknownVector& x,
                         const Priors& priors);

}  // namespace roadbalance
