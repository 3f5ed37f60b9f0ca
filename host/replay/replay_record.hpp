#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>

#include "common/bus/publish.hpp"
#include "host/exchange/survey.hpp"

namespace roadbalance {

struct ReplayReport {
  std::int64_t events = 0;
  std::uint64_t bytes = 0;  ///< of their payloads
  std::int64_t unsent = 0;  ///< events that this computer would not send
  double drive_s = 0.0;     ///< of the recording's time
  /// By how much later than its time an event was given to the bus, over those that were waited for.
  double late_rms_s = 0.0, late_most_s = 0.0;
};

/// How far it is, in seconds of the recording.
using ReplayProgress = std::function<void(double done_s, double of_s)>;

/// Gives every event of a recording to the bus again, as it stands and in its order: what `lcm-logplayer`
/// does with each segment in turn.
///
/// An event's time is that of the newest sample before it, as the recording tells time: what came late
/// (repaired, or a simulation's, faster than real time) is played as it was measured, not as it was written.
/// @param survey  of this folder
/// @param speed   seconds of the recording a second; nothing: as fast as the bus takes it
/// @throws std::system_error if the folder cannot be read
ReplayReport replay_record(const std::filesystem::path& folder, const RecordingSurvey& survey,
                           const std::optional<double>& speed, const Publish& publish,
                           const std::stop_token& stop, const ReplayProgress& progress = {});

}  // namespace roadbalance
