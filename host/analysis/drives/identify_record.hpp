#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <vector>

#include "common/bus/compensation.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/block.hpp"
#include "host/analysis/balance/overall_plan.hpp"
#include "host/analysis/identify/drive_estimator.hpp"
#include "host/analysis/identify/stretch.hpp"
#include "host/recording/read_recording.hpp"

namespace roadbalance {

/// The estimate was cancelled.
struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted") {}
};

/// A finished recording that has gone through DriveEstimator.
struct DrivenRecording {
  std::optional<VehicleConfig> vehicle;
  std::unique_ptr<DriveEstimator> estimator;
  RecordingDefects defects;
  /// For wheels whose angles were computed again: uncertainty common to the whole drive, rad, else 0.
  std::array<double, kWheels> common_sigma_rad{};
  /// Sentences for people: the evidence against their marks, and the nodes that the recording lacks,
  /// all of it or for a time.
  std::string contradictions;
};

/// @param refine  as in identify_record
/// @param stop    asked between blocks
/// @param see     each block, too
/// @throws as read_recording; Interrupted when asked to stop
DrivenRecording driven_recording(const std::filesystem::path& folder, bool refine,
                                 const std::stop_token& stop,
                                 const std::function<void(const SealedBlock&)>& see = {});

struct RecordedEstimate {
  DriveEstimate estimate;
  std::string refusal;  ///< why this vehicle, a wheel of it or this drive is not identified; empty: it is
  std::vector<std::string> diagnostics;  ///< what it rests on, and where the car is not as it was described
  RecordingDefects defects;
  std::array<Compensation, kWheels> compensation;  ///< of each balance
  std::optional<OverallPlan> overall;  ///< of all speeds together; none if the wheels' forces are not known
};

/// The estimate that a finished recording gives: every block of every node in sequence through
/// DriveEstimator, the path the live analyser takes, so the numbers are the same bit for bit.
///
/// But of wheels whose teeth are counted on the bus: their angles are computed again from all that was
/// recorded (AngleReprocessor), and what is not known of them is in the result.
///
/// @param refine  do not use the clocks' relations and the wheels' angles as they were known live: compute
///                them again from the recorded exchanges and edges, with what came before and after each
///                instant
/// @param stop    asked between blocks
/// @throws as read_recording; Interrupted when asked to stop
RecordedEstimate identify_record(const std::filesystem::path& folder, bool refine = false,
                                 const std::stop_token& stop = {});

/// The same of a drive, or of many together, that has gone through identification.
/// @param common_sigma_rad  uncertainty of each wheel's angle all through the drive
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
