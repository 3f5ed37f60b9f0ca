#pragma once

#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "tools/rb/finding.hpp"

namespace roadbalance {

/// What of vehicle.toml makes grams and angles worse than they need be, or their ± smaller than they are: one
/// finding if nothing does, else one for each such thing.  None of a car that cannot be identified.
/// @param file  that it was read from
std::vector<Finding> accuracy_findings(const VehicleConfig& vehicle, const std::string& file);

}  // namespace roadbalance
