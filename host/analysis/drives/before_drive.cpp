#include "host/analysis/drives/before_drive.hpp"

#include <exception>
#include <stdexcept>
#include <system_error>

#include "host/analysis/drives/identify_record.hpp"
#include "host/recording/recorded_vehicle.hpp"

namespace roadbalance {
namespace {

std::string name_of(const std::filesystem::path& folder) {
  const std::filesystem::path whole = std::filesystem::absolute(folder).lexically_normal();
  return whole.has_filename() ? whole.filename().string() : whole.parent_path().filename().string();
}

}  // namespace

BalancedDrive evaluate_drive(const std::filesystem::path& folder, const std::stop_token& stop) {
  const RecordedEstimate found = identify_record(folder, false, stop);
  return {name_of(folder), recorded_vehicle(folder).value(), found.estimate.balance, found.compensation};
}

std::optional<std::filesystem::path> drive_before_weights(const std::filesystem::path& record,
                                                          const VehicleConfig& vehicle) {
  const std::filesystem::path here = std::filesystem::absolute(record).lexically_normal();
  std::optional<std::filesystem::path> newest;
  std::filesystem::file_time_type newest_time{};
  std::error_code error;
  for (const auto& place : std::filesystem::directory_iterator(here.parent_path(), error)) {
    const auto time = place.last_write_time(error);
    if (error || !place.is_directory(error) || place.path() == here || (newest && time <= newest_time))
      continue;
    try {
      const auto before = recorded_vehicle(place.path());
      if (!before || !weights_were_fitted_between(*before, vehicle)) continue;
    } catch (const std::exception&) {
      continue;  // no recording, or none that can be compared with
    }
    newest = place.path();
    newest_time = time;
  }
  return newest;
}

void recall_before(std::stop_token stop, const std::filesystem::path& folder, Out<BalancedDrive> drive,
                   const std::function<void(const std::string&)>& warn) {
  try {
    drive.send(evaluate_drive(folder, stop));
  } catch (const Interrupted&) {
    return;
  } catch (const std::exception& error) {
    warn("--before " + folder.string() + ": " + error.what());
  }
}

}  // namespace roadbalance
