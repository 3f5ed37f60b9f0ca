#pragma once

#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "host/analyser/chosen_vehicle.hpp"

namespace roadbalance {

struct AnalyserOptions {
  std::string url;               ///< of the bus
  std::filesystem::path record;  ///< folder that the recorder writes
  /// Finished recording of the drive before weights were fitted, to compare with; empty: none.
  std::filesystem::path before{};
  bool find_before = false;  ///< without one look for it beside the record (drive_before_weights)
  /// The recorder's vehicle.toml: the live view goes by the file beside it that the nodes measure by; empty:
  /// by the record's.  With follow_recordings see there, too.
  std::filesystem::path vehicle{};
  bool exit_at_end = false;  ///< return once every node has ended and the last estimate is out
  /// With exit_at_end: not before this returns true; called from another thread.
  std::function<bool()> may_exit = [] { return true; };
  /// Hears who on the bus is of another version of the wire.  Called from several threads.
  std::function<void(const std::string&)> on_warning = [](const std::string&) {};
};

/// Where the live view looks for the vehicle that is in force.
VehicleByCrc vehicle_files_of(const AnalyserOptions& options);

/// Process: record and bus -> results on the bus.
///
/// Waits for the record's vehicle, then runs two processes side by side: the live view (levels and
/// spectra of what the bus brings; it may skip and counts that) and identification (of the record as it
/// grows; complete, in sequence).  Uses nothing that is not in the record.
///
/// Returns when asked to stop.
/// @throws ConfigError if the record's vehicle cannot be analysed, std::runtime_error if there is no bus or
/// the
///         record is of another version of the wire
void run_analyser(std::stop_token stop, const AnalyserOptions& options);

}  // namespace roadbalance
