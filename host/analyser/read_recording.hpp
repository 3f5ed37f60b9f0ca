#pragma once

#include <filesystem>
#include <functional>

#include "common/config/vehicle_config.hpp"
#include "common/link/block.hpp"

namespace roadbalance {

/// Hands over every block of a finished recording, each node's in sequence, as the live analyser sees them.
///
/// @param begin    called once, before the first block
/// @param consume  called with each block
/// @throws std::system_error if the folder cannot be read, ConfigError if it holds no usable vehicle.toml,
///         std::runtime_error naming the node if a block is missing undeclared
void read_recording(const std::filesystem::path& folder,
                    const std::function<void(const VehicleConfig&)>& begin,
                    const std::function<void(const SealedBlock&)>& consume);

}  // namespace roadbalance
