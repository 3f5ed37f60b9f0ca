#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/bus/compensation.hpp"
#include "host/analyser/driven_recording.hpp"
#include "host/analyser/read_recording.hpp"
#include "host/balance/overall_plan.hpp"
#include "host/identify/drive_estimator.hpp"
#include "host/identify/stretch.hpp"

namespace roadbalance {

struct RecordedEstimate {
  DriveEstimate estimate;
  std::string obstacle;  ///< why this vehicle, a wheel of it or this drive is not identified; empty: it is
  std::vector<std::string> remarks;  ///< what it rests on, and where the car is not as it was described
  RecordingDefects defects;
  std::array<Compensation, kWheels> compensation;  ///< of each balance
  std::optional<OverallPlan> overall;  ///< of all speeds together; none if the wheels' forces are not known
};

/// The estimate that a finished recording gives: every block of every node in sequence through
/// DriveEstimator, the path the live analyser takes, so the numbers are the same bit for bit.
///
/// But of wheels whose teeth are counted on the bus: their angles are computed again from all that was
/// recorded (AngleAgain), and what is not known of them is in the result.
///
/// @param refine  do not use the clocks' relations and the wheels' angles as they were known live: compute
///                them again from the recorded exchanges and edges, with what came before and after each
///                instant
/// @param stop    asked between blocks
/// @throws as read_recording; Interrupted if told to stop
RecordedEstimate identify_record(const std::filesystem::path& folder, bool refine = false,
                                 const std::stop_token& stop = {});

/// The same of a drive, or of many together, that has gone through identification.
/// @param common_sigma_rad  doubt of each wheel's angle all through the drive
/// @param forces            of the estimate
RecordedEstimate recorded_estimate(DriveEstimate estimate, const DriveForces& forces,
                                   const VehicleConfig& vehicle,
                                   const std::array<double, kWheels>& common_sigma_rad);

/// The steady stretches of a finished recording for any Estimator: the same blocks and angles.
///
/// @throws as read_recording; ConfigError if the sensors do not determine the seven coordinates, or the
/// nodes' samples do not lie on one grid
RecordingDefects collect_stretches(const std::filesystem::path& folder, bool refine,
                                   const std::function<void(const Stretch&)>& emit);

}  // namespace roadbalance
