#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "tools/doctor/finding.hpp"

namespace roadbalance {

Finding writable_folder(const std::filesystem::path& folder);
/// The finding if `folder` cannot be written to.
/// @param place  the nearest folder that exists, which takes no new file; @param error  errno of trying
Finding unwritable_folder(const std::filesystem::path& folder, const std::filesystem::path& place, int error);

/// Why what a recorder has acknowledged may not last on a file system of this kind; nothing: there it does.
/// @param kind  statfs(2)'s f_type
std::optional<Finding> file_system(const std::filesystem::path& folder, std::int64_t kind);

/// Growth of a drive's recording.
struct RecordingRate {
  std::string of;  ///< "three nodes of 16 channels at 2 kHz"
  double bytes_s = 0.0;
};
/// Growth with three ordinary nodes.
RecordingRate ordinary_rate();
/// At the most: samples and signals uncompressed, all wheels at 250 km/h.
RecordingRate rate_of(const VehicleConfig& vehicle);

/// Properties of the disk of a folder.
struct DiskMeasurement {
  std::uint64_t free_bytes = 0;
  std::chrono::duration<double> worst_sync{};  ///< of some writes of a block each with fdatasync
};
/// @throws std::system_error if no file can be made there
DiskMeasurement measure_disk(const std::filesystem::path& folder);
Finding disk(const std::filesystem::path& folder, const DiskMeasurement& measured, const RecordingRate& rate);

/// All of these of a folder that is there or would be made.
std::vector<Finding> examine_folder(const std::filesystem::path& folder, const RecordingRate& rate);

}  // namespace roadbalance
