#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>

#include "host/exchange/survey.hpp"

namespace roadbalance {

/// Writes the pulses of all wheels as `rb import csv --pulses` takes them: time_s,wheel,kind in order of
/// time, with kind tooth or zero, and of devices that know more tooth_backward (the wheel turned back) and
/// lost (edges were missed before).
///
/// @param selection  of which the times count, not the channels
/// @return how many
/// @throws std::system_error naming the file, std::runtime_error if `stop` was requested
std::int64_t write_pulses(const std::filesystem::path& folder, const VehicleConfig& vehicle,
                          const ExportTable& table, const ExportSelection& selection,
                          const std::filesystem::path& file, const std::stop_token& stop);

}  // namespace roadbalance
