#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hil_tests/players/node_drive.hpp"
#include "hil_tests/players/timetable.hpp"
#include "host/analysis/identify/drive_estimator.hpp"

namespace roadbalance::test {

/// How much later than their truth stamps are.
class StampError {
 public:
  void add(NodeClock::duration late);
  double mean_s() const { return count_ == 0 ? 0.0 : sum_s_ / static_cast<double>(count_); }
  double rms_about_mean_s() const;
  double spread_s() const;  ///< most that any is off from the mean
  std::int64_t count() const { return count_; }
  /// "12000 stamps late by 3.1 us, +- 0.2 us, 2.5 to 9.0 us"
  std::string text() const;

 private:
  std::int64_t count_ = 0;
  double sum_s_ = 0.0, sum_of_squares_s2_ = 0.0, least_s_ = 0.0, most_s_ = 0.0;
};

/// Result of playing a node's drive.
struct DriveDifference {
  std::int64_t scans = 0;  ///< missing, or with a count that differs
  std::int64_t edges = 0;  ///< missing, too many, or of another kind
  std::int64_t samples =
      0;  ///< of signals, likewise, or whose value differs by more than half a step of its code
  StampError scan, edge, sample;

  /// How much the edges are later than the scans on the average: a wheel's angle is wrong by that times its
  /// speed.
  double mean_angle_time_s() const { return edge.mean_s() - scan.mean_s(); }
  /// At no instant is it off from that by more.
  double angle_time_spread_s() const;
};

/// @param truth, seen  what was played, and what was recorded of it
/// @param timetable    by which it was played, in the clock of `seen`
/// @param half_step    of the coded signals, in their unit
DriveDifference compare(const NodeDrive& truth, const NodeDrive& seen, const Timetable& timetable,
                        double half_step);

/// A recording of one node.
NodeDrive recorded_drive(const std::filesystem::path& folder, const VehicleConfig& vehicle,
                         const NodeConfig& node);

/// The estimate that a finished recording gives if the scans before an instant are left out: two recordings
/// of one drive are cut into the same sections then.
DriveEstimate identify_from(const std::filesystem::path& folder, NodeTime from);

/// The recorder's notes of the troubles of nodes' devices.
std::vector<std::string> device_troubles(const std::filesystem::path& folder);

}  // namespace roadbalance::test
