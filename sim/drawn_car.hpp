#pragma once

#include <array>
#include <complex>
#include <cstdint>

#include "common/vehicle/linear_model.hpp"
#include "sim/scenario.hpp"

namespace roadbalance::sim {

/// The one car that a scenario and a seed stand for.
struct DrawnCar {
  Geometry geometry;
  ParameterVector parameters;
  std::array<double, kWheels> rolling_radius_m;
  std::array<double, kWheels> initial_angle_rad;  ///< wheel angle at bus time 0, wander aside
  std::array<WheelScenario, kWheels> wheel;
};

/// Springs, dampers, stabilisers and tyres are drawn, and with sigma_spread masses, inertias and tyre
/// dampers; places are those of vehicle.toml. No two rolling radii are closer than half the spread, so no two
/// wheels turn in step.
DrawnCar draw_car(const Scenario& scenario, std::uint64_t seed, const VehicleConfig& vehicle);

}  // namespace roadbalance::sim
