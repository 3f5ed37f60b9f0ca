#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace roadbalance {

struct ClockSkewOptions {
  std::string bus_url;           ///< a bus of its own
  std::filesystem::path folder;  ///< of the recording, empty
  double seconds = 30.0;
  int nodes = 4;  ///< 2 .. 16; the demo's car, each node with its own clock
};

/// Runs real nodes and a real recorder on this machine in real time.  The nodes' clocks are simulated: off by
/// hours, up to 60 ppm fast or slow, and so are their converters.  Twenty times a second it compares the fits
/// on the bus with the nodes' true clocks:
///
///     {"nodes", "seconds", "skew_p50_us", "skew_p99_us", "skew_max_us", "error_p99_us",
///      "uncertainty_p50_us", "windows", "covered_percent", "kernel_stamps_percent", "met"}
///
/// Skew is the difference of two nodes' errors, over all pairs; a window is the time that one fit is the
/// newest, and is covered if no error in it is larger than the fit's uncertainty and 0.5 ppm of its age.  The
/// first fits, until each node has had one for two seconds, are not counted.
/// @throws std::runtime_error if the nodes cannot be run or no fit comes
nlohmann::ordered_json clock_skew(const ClockSkewOptions& options);

}  // namespace roadbalance
