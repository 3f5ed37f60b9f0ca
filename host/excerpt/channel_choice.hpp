#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// What of a recording is wanted, by the names of vehicle.toml.
struct ChannelChoice {
  std::vector<std::string> nodes = {};     ///< empty: all
  std::vector<std::string> channels = {};  ///< of channels, or of nodes for all of theirs; empty: all

  bool operator==(const ChannelChoice&) const = default;
};

/// @throws ConfigError naming a node or channel that the vehicle has not, or if nothing is left
void check_choice(const ChannelChoice& choice, const VehicleConfig& vehicle);

/// Bit k: channel k of the node's scans is wanted, the wheels' references with any other; 0: the node is not.
std::uint32_t chosen_channels(const ChannelChoice& choice, const NodeConfig& node);

/// vehicle.toml as it is true of what is chosen, every `factor`-th sample of it: channels that are left out
/// are unused, rate_hz is that of what is left, and identification works at that if it was to at more, or at
/// a rate that does not divide it.  All else stays as its user wrote it.
/// @throws ConfigError naming what cannot be: a rate that its filter is too fast for
std::string excerpt_vehicle(const std::string& text, const ChannelChoice& choice, int factor);

}  // namespace roadbalance
