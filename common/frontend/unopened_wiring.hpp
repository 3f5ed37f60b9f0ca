#pragma once

#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The wiring that vehicle.toml gives the node, but none of its front ends will read: a sentence for each, as
/// nothing else would ever show it.  Empty if a front end stands in for all hardware (sim:, replay:).
///
/// @param uris  the front ends that are opened
std::vector<std::string> unopened_wiring(const NodeConfig& node, const std::vector<std::string>& uris);

}  // namespace roadbalance
