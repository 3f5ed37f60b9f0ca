#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

enum class GpioTrack : std::uint8_t { kTooth, kDirection, kZeroMark };

/// A GPIO that an encoder's track is wired to.
struct GpioInput {
  unsigned offset = 0;
  std::uint8_t line = 0;  ///< of the node, as Edge::line
  GpioTrack track = GpioTrack::kTooth;
  std::string key;  ///< for messages: "[[node.line]] line 0 of node front: tooth_gpio"
};

/// The inputs of the node, from [[node.line]].
/// @param device  for messages, e.g. "gpio:gpiochip0"
/// @param warn    gets what will not do what may be expected
/// @throws ConfigError if there are none
std::vector<GpioInput> gpio_inputs(const std::string& device, const VehicleConfig& vehicle,
                                   const NodeConfig& node,
                                   const std::function<void(const std::string&)>& warn);

}  // namespace roadbalance
