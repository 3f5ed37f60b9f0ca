#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/scenario.hpp"

namespace roadbalance::sim {

/// Where the car is on its way.
struct Motion {
  double position_m;
  double speed_m_s;
  double acceleration_m_s2;
};

/// The drive in closed form, so that any instant can be asked for without what came before.
///
/// Speed = plateaus joined by quintic smooth steps (speed, acceleration and jerk continuous) + four sinusoids
/// with periods of 7 .. 40 s + a drift that grows from time 0 to the end; position is its exact integral.
/// Before time 0 and after the end the speed of the first and the last plateau goes on.
class Drive {
 public:
  Drive(const DriveScenario& scenario, std::uint64_t seed);

  Motion at(double time_s) const;

 private:
  /// A plateau with the ramp that leads to it.
  struct Leg {
    double start_s;
    double start_m;
    double speed_before_m_s;
    double speed_m_s;
    double ramp_s;
  };
  struct Wander {
    double amplitude_m_s;
    double rate_rad_s;
    double phase_rad;
  };
  static Motion on_leg(const Leg& leg, double time_s);
  Motion drift(double time_s) const;

  std::vector<Leg> leg_;
  std::array<Wander, 4> wander_;
  double drift_m_s2_, end_s_;
};

}  // namespace roadbalance::sim
