#pragma once

#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The signals that the encoders of a node need and vehicle.toml does not give it, a sentence each: their
/// angles will be uncertain, or unknown.
std::vector<std::string> missing_signals(const VehicleConfig& vehicle, const NodeConfig& node);

}  // namespace roadbalance
