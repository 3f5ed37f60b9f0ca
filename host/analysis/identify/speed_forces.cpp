#include "host/analysis/identify/speed_forces.hpp"

#include <cmath>

namespace roadbalance {

DriveForces drive_forces(const std::vector<DriveMoments>& classes, const UnknownVector& x,
                         const Priors& priors) {
  DriveForces drive{priors.value, {}};
  drive.parameters.segment<kEstimatedUnbalance>(kSpring) = x.head<kEstimatedUnbalance>();
  for (const DriveMoments& total : classes) {
    const double speed_m_s = total.speed_seconds / total.seconds;
    SpeedForces& speed = drive.speed.emplace_back(
        SpeedForces{speed_m_s, total.seconds,
                    first_order_forces(total.harmonic, priors.geometry, drive.parameters,
                                       speed_m_s * priors.rolling_radius_m.cwiseInverse())});
    for (FirstOrderForce& force : speed.wheel)
      if (!(force.variance_n2 > 0.0) || !std::isfinite(force.variance_n2)) force.variance_n2 = 0.0;
  }
  return drive;
}

}  // namespace roadbalance
