#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>

#include "common/config/vehicle_config.hpp"
#include "common/link/block.hpp"
#include "host/analyser/read_recording.hpp"
#include "host/identify/drive_estimator.hpp"

namespace roadbalance {

/// Somebody who asked for an estimate no longer wants it.
struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted") {}
};

/// A finished recording that has gone through DriveEstimator.
struct DrivenRecording {
  std::optional<VehicleConfig> vehicle;
  std::unique_ptr<DriveEstimator> estimator;
  RecordingDefects defects;
  /// Of wheels whose angles were computed again: their doubt all through the drive, rad, else 0; and what
  /// speaks against their marks, for people.
  std::array<double, kWheels> common_sigma_rad{};
  std::string contradictions;
};

/// @param refine  as in identify_record
/// @param stop    asked between blocks
/// @param see     each block, too
/// @throws as read_recording; Interrupted if told to stop
DrivenRecording driven_recording(const std::filesystem::path& folder, bool refine,
                                 const std::stop_token& stop,
                                 const std::function<void(const SealedBlock&)>& see = {});

}  // namespace roadbalance
