#pragma once

#include <filesystem>

#include "host/identify/drive_estimator.hpp"

namespace roadbalance {

/// The estimate that a finished recording gives: every block of every node in sequence through
/// DriveEstimator, the path the live analyser takes, so the numbers are the same bit for bit.
///
/// @throws std::system_error if the folder cannot be read, ConfigError if it holds no vehicle or one whose
///         sensors do not determine the seven coordinates
DriveEstimate identify_record(const std::filesystem::path& folder);

}  // namespace roadbalance
