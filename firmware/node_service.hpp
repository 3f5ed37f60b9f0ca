#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "firmware/converter_settings.hpp"
#include "firmware/node.hpp"

namespace roadbalance {

/// Opens the node's devices.  @throws ConfigError if they do not have what the vehicle.toml asks for
using OpenFrontEnd =
    std::function<std::unique_ptr<FrontEnd>(const VehicleConfig& vehicle, const NodeConfig& node)>;

/// A node that outlives its recordings: run_node again and again, each time in a new epoch.
///
/// Between recordings it takes another vehicle.toml from its recorder: closes the devices and opens them by
/// it.  One that it cannot measure by is refused with the reason, and the one before stays in force.
/// @param device  the settings that `open` can follow
/// @param stays   after a stop by command: waits for the next start, until its device ends
/// @return as run_node, over all epochs
/// @throws as run_node; ConfigError or std::system_error of `open` the first time, or if the devices cannot
/// be
///         opened again by a vehicle.toml by which they could before
std::int64_t serve_node(std::stop_token stop, VehicleConfig vehicle, const std::string& node_name,
                        const OpenFrontEnd& open, const ConverterSettings& device, bool stays,
                        const NodeOptions& options);

}  // namespace roadbalance
