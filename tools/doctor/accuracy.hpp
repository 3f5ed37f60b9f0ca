#pragma once

#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "tools/doctor/finding.hpp"

namespace roadbalance {

/// Entries of vehicle.toml that make grams and angles worse than they need be, or their ± smaller than they
/// are: one finding if there are none, else one for each.  None of a car that cannot be identified.
/// @param file  that it was read from
std::vector<Finding> accuracy_findings(const VehicleConfig& vehicle, const std::string& file);

}  // namespace roadbalance
