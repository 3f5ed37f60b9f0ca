#pragma once

#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/frontend/front_end.hpp"

namespace roadbalance::test {

/// All data of the devices of one node in a drive: 0.2 MB for each second at 2 kHz.
struct NodeDrive {
  std::vector<Scan> scans;
  std::vector<Edge> edges;            ///< in order of time
  std::vector<SignalSample> signals;  ///< in order of time
  double converter_ppm = 0.0;         ///< how much faster than nominal its converter ran
  NodeClock::duration worst_stamp{};  ///< how far a scan's time was from those of an even converter

  NodeTime first_scan() const { return scans.front().time; }
};

/// Reads a front end to its end.
/// @param name  of the node, for errors
/// @throws ConfigError if it gives no scans, has a gap, which no converter can play, or does not wait for its
///         reader (rate=max); std::runtime_error if it fails
NodeDrive read_drive(FrontEnd& source, const std::string& name, double rate_hz);

}  // namespace roadbalance::test
