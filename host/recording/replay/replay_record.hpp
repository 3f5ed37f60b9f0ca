#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>

#include "common/bus/publish.hpp"
#include "host/recording/formats/survey.hpp"

namespace roadbalance {

struct ReplayReport {
  std::int64_t events = 0;
  std::uint64_t bytes = 0;  ///< of their payloads
  std::int64_t unsent = 0;  ///< events that this computer refused to send
  double drive_s = 0.0;     ///< of the recording's time
  /// Delay of events against their time, over those that were waited for.
  double late_rms_s = 0.0, late_most_s = 0.0;
};

/// Progress, in seconds of the recording.
using ReplayProgress = std::function<void(double done_s, double of_s)>;

/// Publishes every event of a recording on the bus again, unchanged and in its order, as `lcm-logplayer` does
/// with each segment in turn.
///
/// An event's time is that of the newest sample before it, on the recording's clock: samples that came late
/// (repaired, or of a simulation faster than real time) are played as they were measured, not as they were
/// written.
/// @param survey  of this folder
/// @param speed   seconds of the recording a second; nothing: as fast as the bus takes it
/// @throws std::system_error if the folder cannot be read
ReplayReport replay_record(const std::filesystem::path& folder, const RecordingSurvey& survey,
                           const std::optional<double>& speed, const Publish& publish,
                           const std::stop_token& stop, const ReplayProgress& progress = {});

}  // namespace roadbalance
