#pragma once

#include "sim/drawn_car.hpp"

namespace roadbalance::sim {

/// The true values of the simulated car.  For the demo and for studies, which print it beside the result; no
/// program that analyses may include this.
struct Truth {
  struct Wheel {
    double unbalance_g;  ///< at the weight radius of vehicle.toml
    double angle_deg;    ///< heavy spot from the reference point in the direction of rotation, 0 .. 360
    double tyre_stiffness_n_m;
    double radial_force_n;
  };
  std::array<Wheel, kWheels> wheel;
  DrawnCar car;
};

/// @param scenario_path  empty: the demo scenario
/// @throws ConfigError
Truth truth_of(const std::string& scenario_path, std::uint64_t seed, const VehicleConfig& vehicle);

}  // namespace roadbalance::sim
