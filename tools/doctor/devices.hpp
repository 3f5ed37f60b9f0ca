#pragma once

#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "tools/doctor/finding.hpp"

namespace roadbalance {

/// Opens each device that the node is wired to as rb-node does - a CAN interface must be listen-only on the
/// car's own bus, a GPIO chip and a USB board must be there and allowed - and lets go of it again.  One
/// finding for each, and for each encoder and bus that the vehicle file describes and no device of it reads.
std::vector<Finding> device_findings(const VehicleConfig& vehicle, const NodeConfig& node);

}  // namespace roadbalance
