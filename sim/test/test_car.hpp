#pragma once

#include <string>

#include "common/config/vehicle_config.hpp"
#include "sim/scenario.hpp"

namespace roadbalance::sim::test {

/// The car of the reference numbers, with a front and a rear node of twelve channels: x, y, z on the left
/// carrier, the right carrier, the left and the right strut top.
inline VehicleConfig reference_vehicle() {
  VehicleConfig vehicle;
  vehicle.name = "reference car";
  vehicle.model = {
      1300.0,
      480.0,
      2200.0,
      0.0,
      0.0,
      0.0,
      {AxleConfig{1.25, 0.74, 22e3, 1500.0, 12e3, 215e3}, AxleConfig{-1.45, 0.74, 24e3, 1600.0, 5e3, 210e3}}};
  for (std::size_t w = 0; w < kWheels; ++w) {
    WheelConfig& wheel = vehicle.wheel[w];
    wheel.name = kWheelNames[w];
    wheel.mass_kg = w < 2 ? 34.0 : 32.0;
    wheel.mass_sigma_kg = 0.0;
    wheel.rolling_radius_m = 0.30;
    wheel.weight_radius_m = 0.19;
    wheel.node = w < 2 ? "front" : "rear";
    wheel.line = static_cast<int>(w % 2);
    wheel.encoder.pulses_per_turn = 96;
  }
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    NodeConfig node{axle == 0 ? "front" : "rear", static_cast<int>(axle) + 1, 2000.0, {}};
    for (int place = 0; place < 4; ++place) {
      for (int axis = 0; axis < 3; ++axis) {
        ChannelConfig channel;
        channel.name = std::to_string(place) + "xyz"[axis];
        channel.mount = place < 2 ? kWheelNames[2 * axle + static_cast<std::size_t>(place)] : "body";
        const AxleConfig& a = vehicle.model.axle[axle];
        const double y_m = place % 2 == 0 ? a.half_track_m : -a.half_track_m;
        channel.position_m = {a.x_m, y_m, place < 2 ? -0.25 : 0.30};
        channel.direction = Eigen::Vector3d::Unit(axis);
        channel.range_m_s2 = 200.0;
        channel.gain_sigma = 0.0;
        channel.scale_m_s2_per_count = channel.range_m_s2 / kFullScaleCounts;
        node.channel.push_back(channel);
      }
    }
    vehicle.node.push_back(node);
  }
  return vehicle;
}

/// Constant speed on a flat road, a car exactly as in vehicle.toml, ideal sensors and encoders.
inline Scenario ideal_scenario(double speed_m_s) {
  Scenario scenario{};
  scenario.seed = 1;
  scenario.drive = {{{speed_m_s, 60.0}}, 6.0, 0.0};
  return scenario;
}

}  // namespace roadbalance::sim::test
