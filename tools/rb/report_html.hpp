#pragma once

#include <array>
#include <optional>
#include <string>

#include "common/bus/recording.hpp"
#include "common/bus/verification.hpp"
#include "common/config/vehicle_config.hpp"
#include "host/analyser/identify_record.hpp"
#include "host/recorder/recorded_alarms.hpp"
#include "tools/rb/drive_account.hpp"

namespace roadbalance {

/// All that a report of a drive tells.
struct DriveReport {
  VehicleConfig vehicle;
  bool vehicle_known = true;  ///< else `vehicle` has a name that says so and nothing else
  RecordedEstimate found;
  RecordingReceipt receipt;
  RecordedAlarms alarms{};
  std::optional<std::array<WheelVerification, kWheels>> verification{};  ///< with the drive before weights
  std::string
      failure{};  ///< why nothing was identified, or what could not be compared; empty: nothing failed
  std::optional<DriveAccount> account{};  ///< of `vehicle`; nothing: the first page alone
};

/// One HTML file without anything from elsewhere, which prints to an A4 page, and the account on pages
/// of their own behind it.  Each section is a function of
/// its own; what comes of a recording is escaped.
std::string report_html(const DriveReport& report);

}  // namespace roadbalance
