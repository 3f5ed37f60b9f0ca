#pragma once

#include <array>
#include <optional>
#include <string>

#include "common/bus/recording.hpp"
#include "common/bus/verification.hpp"
#include "common/config/vehicle_config.hpp"
#include "host/analyser/identify_record.hpp"
#include "host/recorder/recorded_alarms.hpp"

namespace roadbalance {

/// All that a report of a drive tells.
struct DriveReport {
  VehicleConfig vehicle;
  RecordedEstimate found;
  RecordingReceipt receipt;
  RecordedAlarms alarms{};
  std::optional<std::array<WheelVerification, kWheels>> verification{};  ///< with the drive before weights
};

/// One HTML file without anything from elsewhere, which prints to an A4 page.  Each section is a function of
/// its own; what comes of a recording is escaped.
std::string report_html(const DriveReport& report);

}  // namespace roadbalance
