#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string_view>

#include "host/exchange/survey.hpp"

namespace roadbalance {

/// What a kind is called in such a file, by EdgeKind.
inline constexpr std::array<std::string_view, 4> kPulseKinds{"tooth", "zero", "tooth_backward", "lost"};

struct WrittenPulses {
  std::int64_t written = 0;
  std::int64_t left_out = 0;  ///< for nobody can tell their time
};

/// Writes the pulses of all wheels as `rb import csv --pulses` takes them: time_s,wheel,kind in order of
/// time, with kind tooth or zero, and of devices that know more tooth_backward (the wheel turned back) and
/// lost (edges were missed before).
///
/// @param selection  of which the times count, not the channels
/// @throws std::system_error naming the file, std::runtime_error if `stop` was requested
WrittenPulses write_pulses(const std::filesystem::path& folder, const RecordingSurvey& survey,
                           const ExportTable& table, const ExportSelection& selection,
                           const std::filesystem::path& file, const std::stop_token& stop);

}  // namespace roadbalance
