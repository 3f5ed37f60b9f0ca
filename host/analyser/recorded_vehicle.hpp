#pragma once

#include <filesystem>
#include <optional>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The vehicle.toml that the first node stored in a recording; nothing while it is not complete.
/// @throws ConfigError if it is complete and cannot be used
std::optional<VehicleConfig> recorded_vehicle(const std::filesystem::path& folder);

}  // namespace roadbalance
