#pragma once

#include <filesystem>
#include <optional>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The vehicle.toml that the first node stored in a recording, with the rate at which the samples were really
/// taken in place of the nominal one; nothing while the description or the first scan is not there.
/// @throws ConfigError if it is complete and cannot be used; std::runtime_error, naming the programs with
/// another
///         version of the wire, if the recording holds nothing else
std::optional<VehicleConfig> recorded_vehicle(const std::filesystem::path& folder);

/// The same for a recording that must have it.
/// @throws also std::system_error naming the folder if there is none or it holds no segment;
///         std::runtime_error if nothing in it can be read
VehicleConfig vehicle_of_recording(const std::filesystem::path& folder);

}  // namespace roadbalance
