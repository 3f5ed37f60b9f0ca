#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The wanted nodes and channels of a recording, by the names of vehicle.toml.
struct ChannelChoice {
  std::vector<std::string> nodes = {};  ///< empty: all
  std::vector<std::string> channels =
      {};  ///< names of channels, or of nodes for all of their channels; empty: all

  bool operator==(const ChannelChoice&) const = default;
};

/// @throws ConfigError naming a node or channel that the vehicle lacks, or if nothing is left
void check_choice(const ChannelChoice& choice, const VehicleConfig& vehicle);

/// Bit k: channel k of the node's scans is wanted; the wheels' references come with any other.  0: the node
/// is not wanted.
std::uint32_t chosen_channels(const ChannelChoice& choice, const NodeConfig& node);

/// The vehicle.toml of every `factor`-th sample of the chosen channels: other channels are unused, rate_hz is
/// the new rate, and so is identification_rate_hz if it was higher or does not divide the new rate.  All else
/// stays as its user wrote it.
/// @throws ConfigError naming the rate if it is too low for the filter
std::string subset_vehicle(const std::string& text, const ChannelChoice& choice, int factor);

}  // namespace roadbalance
