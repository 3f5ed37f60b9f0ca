#pragma once

#include <string>

#include "tools/report/report_html.hpp"

namespace roadbalance {

/// Sections of the account behind the first page of a report, as markup; what comes of a recording is
/// escaped.  `report.account` is there.

std::string account_vehicle(const DriveReport& report);
std::string account_sensors(const DriveReport& report);
std::string account_conditions(const DriveReport& report);
std::string account_levels(const DriveReport& report);
std::string account_spectra(const DriveReport& report);
std::string account_orders(const DriveReport& report);
std::string account_identification(const DriveReport& report);
std::string account_weights(const DriveReport& report);
std::string account_before_and_after(const DriveReport& report);
std::string account_alarms(const DriveReport& report);
std::string account_proof(const DriveReport& report);

}  // namespace roadbalance
