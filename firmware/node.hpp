#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "common/config/vehicle_config.hpp"
#include "common/frontend/front_end.hpp"
#include "common/link/ring.hpp"
#include "firmware/vehicle_change.hpp"

namespace roadbalance {

struct NodeOptions {
  std::string bus_url;
  std::size_t ring_bytes = Ring::kDefaultBytes;
  /// Where blocks go when the ring is half full, in a folder of this run; empty: nowhere.
  std::filesystem::path spool{};
  std::uint64_t spool_bytes = std::uint64_t{1} << 30;
  /// Hears which recorder is of another version of the wire, what the devices suffer, what earlier runs left
  /// in the spool, what the system refuses of real-time priority and locked memory (a device that waits for
  /// its reader has no deadline and asks for neither), and at the end how many scans the device numbered
  /// backwards and what stays in the spool because no recorder took it.  Called from several threads.
  std::function<void(const std::string&)> warn = [](const std::string&) {};
  /// Called about twice a second while what samples, unless it has ended, and what sends turn: proof of life.
  std::function<void()> on_alive = [] {};
};

/// A whole worker node: acquire and uplink side by side with the ring between them.  The same in rb-node and
/// as a thread of another program.
///
/// Begins a new epoch; samples are kept from a recorder's start command on.  Returns when the device has
/// ended or was stopped by command and all that was sealed is durable at the owner, or soon after `stop` is
/// requested; then what no recorder took is moved to the spool.  A bus that fails meanwhile is opened again.
///
/// @return how many blocks that no recorder has, and no spool, are lost with this program: 0 unless it was
///         asked to stop
/// @throws ConfigError if the ring or the spool is too small; std::runtime_error if bus or spool cannot be
///         opened or the device failed (then after all it gave is durable)
std::int64_t run_node(std::stop_token stop, const VehicleConfig& vehicle, const NodeConfig& node,
                      FrontEnd& front_end, const NodeOptions& options);

struct EpochResult {
  std::int64_t lost = 0;      ///< as run_node
  bool device_ended = false;  ///< there is nothing more to be had from it
};

/// One epoch of a node: run_node, which also returns when another vehicle.toml is wanted while nothing is
/// kept.
/// @param is_first  of this program: troubles of devices and system from before are not reported again.  In a
///                  later one a spool that cannot be opened is a failure of the spool, and no end
EpochResult run_epoch(std::stop_token stop, const VehicleConfig& vehicle, const NodeConfig& node,
                      FrontEnd& front_end, const NodeOptions& options, VehicleChange& change, bool is_first);

}  // namespace roadbalance
