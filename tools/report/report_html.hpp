#pragma once

#include <array>
#include <optional>
#include <string>

#include "common/bus/recording.hpp"
#include "common/bus/weight_check.hpp"
#include "common/config/vehicle_config.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "host/recording/recorded_alarms.hpp"
#include "tools/report/drive_account.hpp"

namespace roadbalance {

/// All contents of a report of a drive.
struct DriveReport {
  VehicleConfig vehicle;
  bool vehicle_known = true;  ///< else `vehicle` has a name with that meaning and nothing else
  RecordedEstimate found;
  RecordingSummary receipt;
  RecordedAlarms alarms{};
  std::optional<std::array<WeightCheck, kWheels>> weight_check{};  ///< with the drive before weights
  std::string
      failure{};  ///< why nothing was identified, or what could not be compared; empty: nothing failed
  std::optional<DriveAccount> account{};  ///< of `vehicle`; nothing: the first page alone
};

/// One HTML file without anything from elsewhere, which prints to an A4 page, and the account on pages
/// of their own behind it.  Each section is a function of
/// its own; what comes of a recording is escaped.
std::string report_html(const DriveReport& report);

}  // namespace roadbalance
