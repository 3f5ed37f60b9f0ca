#pragma once

#include <array>
#include <bitset>
#include <complex>
#include <vector>

#include "common/bus/compensation.hpp"
#include "common/config/vehicle_config.hpp"
#include "host/analysis/identify/speed_forces.hpp"

namespace roadbalance {

/// Vertical vibration of the seats that turns with the wheels, m/s^2 rms: the root of the mean square over
/// the seats by their weights.  Wheels keep no phase to one another, so their mean squares add.
struct SeatVibration {
  double now = 0.0;       ///< with the wheels as they were driven
  double by_wheel = 0.0;  ///< each wheel balanced for itself
  double overall = 0.0;   ///< with the overall plan
  double least = 0.0;     ///< with its weights before they were rounded to those that can be bought
};

/// Vibration of the seats by one wheel over the speeds of a drive, m/s^2 rms as in SeatVibration.
struct WheelVibration {
  double now = 0.0;
  double left = 0.0;  ///< with the steps of its own compensation
};

/// Weights that make the vibration of the seats least over all speeds of a drive.
struct OverallPlan {
  struct Wheel {
    WheelWeight best;  ///< at its weight radius; of no mass if the wheel is left alone
    WeightPlan plan;   ///< nearest to it that can be bought; its own if its force is known at no speed
    int radii = 1;     ///< of its compensation
  };
  struct Speed {
    double speed_m_s, seconds;
    SeatVibration vibration;
    std::bitset<kWheels> without_force{};  ///< wheels without one there: their effect is in no figure
  };
  std::vector<SeatConfig> seat;
  std::array<Wheel, kWheels> wheel;
  std::vector<Speed> speed;
  SeatVibration vibration;  ///< over the whole drive
};

/// The seats of vehicle.toml, or else the places of its vertical sensors on the body.
///
/// @throws ConfigError if there is neither
std::vector<SeatConfig> seats_of(const VehicleConfig& vehicle);

/// Overall compensation (compensate_overall) with the response of the identified car,
///
///     H_spw = p_s' G_w(Om) / Om^2,   p_s = (1, y, -x, 0, 0, 0, 0),   R_spw = H_spw a_sw,
///
/// G unbalance_response, a_sw the first-order force of all causes on wheel w.  A seat feels each wheel at
/// that wheel's own frequency: each is a response point of its own, weighed by the seat and the time driven.
/// A wheel whose balance is not known or lies within its uncertainty is left alone.  One without a force
/// at a speed has no share in that speed's vibration, and what is least is least without it.
///
/// @param by_wheel  each wheel's own compensation
/// @throws as seats_of
OverallPlan plan_overall(const DriveForces& drive, const VehicleConfig& vehicle,
                         const std::array<Compensation, kWheels>& by_wheel);

/// For each wheel by itself; the squares of all four add to those of the car.  A wheel's value that no speed
/// shows is NaN.
///
/// @throws as seats_of
std::array<WheelVibration, kWheels> wheel_vibration(const DriveForces& drive, const VehicleConfig& vehicle,
                                                    const std::array<Compensation, kWheels>& by_wheel);

/// compensate() of each wheel, with what the seats feel of it where the drive shows that.
std::array<Compensation, kWheels> compensate_all(const std::array<Balance, kWheels>& balance,
                                                 const DriveForces& drive, const VehicleConfig& vehicle);

}  // namespace roadbalance
