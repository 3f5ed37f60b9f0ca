#pragma once

#include <stop_token>
#include <string>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// Process: publishes once a second what the node is (setup_t), recorded or not.
///
/// While there is no bus it goes on trying: the uplink reports why.  Ends when asked to stop.
void describe(std::stop_token stop, const std::string& bus_url, const VehicleConfig& vehicle,
              const NodeConfig& node);

}  // namespace roadbalance
