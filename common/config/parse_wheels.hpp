#pragma once

#include <string>
#include <vector>

#include "common/config/section.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// kWheelNames.
std::vector<std::string> wheel_name_list();

/// [[wheel]] of vehicle.toml.
/// @param vehicle  its nodes are known
void parse_wheels(Section& root, VehicleConfig& vehicle);

/// [[rotor]].
/// @param vehicle  its wheels are known
void parse_rotors(Section& root, VehicleConfig& vehicle);

}  // namespace roadbalance
