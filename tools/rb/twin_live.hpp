#pragma once

#include <string>

namespace roadbalance {

struct LiveTwinOptions {
  std::string url;
  std::string vehicle;   ///< vehicle.toml by which the nodes measure
  double seconds = 0.0;  ///< 0: until interrupted
  bool json = false;
};

/// Simulates the car beside the nodes on the bus and prints each second what of it is explained; with json an
/// object on a line of its own.
/// @return an ExitCode: whether any channel was predicted
/// @throws ConfigError if the vehicle has no twin
int show_live_twin(const LiveTwinOptions& options);

}  // namespace roadbalance
