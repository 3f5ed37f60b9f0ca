#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string_view>

#include "host/recording/formats/export_table.hpp"
#include "host/recording/formats/survey.hpp"

namespace roadbalance {

/// The name of a kind in such a file, by EdgeKind.
inline constexpr std::array<std::string_view, 4> kPulseKinds{"tooth", "zero", "tooth_backward", "lost"};

struct WrittenPulses {
  std::int64_t written = 0;
  std::int64_t left_out = 0;  ///< whose time is unknown
};

/// Writes the pulses of all wheels as `rb import csv --pulses` reads them: time_s,wheel,kind in order of
/// time. Kinds are tooth and zero, and for devices that report them tooth_backward (the wheel turned back)
/// and lost (edges were missed before).
///
/// @param selection  its times count, its channels do not
/// @throws std::system_error naming the file, std::runtime_error if `stop` was requested
WrittenPulses write_pulses(const std::filesystem::path& folder, const RecordingSurvey& survey,
                           const ExportTable& table, const ExportSelection& selection,
                           const std::filesystem::path& file, const std::stop_token& stop);

}  // namespace roadbalance
