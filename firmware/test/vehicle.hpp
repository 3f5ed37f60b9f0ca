#pragma once

#include <string>

#include "common/config/vehicle_config.hpp"

namespace roadbalance::test {

/// A car with one node, "axle", that has one acceleration and an encoder on each of its lines.
inline VehicleConfig one_node_vehicle(double rate_hz = 2000.0, int teeth = 96) {
  VehicleConfig vehicle{};
  vehicle.name = "test";
  for (int w = 0; w < kWheels; ++w) {
    auto& wheel = vehicle.wheel[static_cast<std::size_t>(w)];
    wheel.name = kWheelNames[static_cast<std::size_t>(w)];
    wheel.encoder = {.pulses_per_turn = teeth};
    if (w < 2) {
      wheel.node = "axle";
      wheel.line = w;
    }
  }
  ChannelConfig channel;
  channel.name = "up";
  channel.mount = "body";
  channel.range_m_s2 = 100.0;
  channel.scale_m_s2_per_count = 100.0 / kFullScaleCounts;
  vehicle.node.push_back({.name = "axle", .id = 3, .rate_hz = rate_hz, .channel = {channel}});
  vehicle.text = std::string(3000, '#');  // three meta blocks
  return vehicle;
}

}  // namespace roadbalance::test
