#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "host/analysis/angle/angle_reprocessor.hpp"
#include "host/recording/read_recording.hpp"

namespace roadbalance {

/// Blocks and fits of a recording as identification takes them; the first three must be there.
struct BlockReader {
  std::function<void(const VehicleConfig&)> begin;
  std::function<void(const SealedBlock&)> consume;
  std::function<void(const ClockFit&)> consume_fit;
  std::function<void(const LogEvent&)> consume_other{};  ///< as read_recording
};

/// read_recording, but wheels whose teeth are counted on the bus have their angles computed from all that was
/// recorded; with `refine` clocks and the other wheels' angles, too.
///
/// @param angles  made here, if the recording has a vehicle
/// @throws as read_recording
RecordingDefects read_with_angles(const std::filesystem::path& folder, bool refine,
                                  std::optional<AngleReprocessor>& angles, const BlockReader& reader);

}  // namespace roadbalance
