#pragma once

#include <map>
#include <string>

#include "common/bus/operation.hpp"
#include "host/recorder/control/standstill_readings.hpp"
#include "host/recorder/control/turn_over.hpp"

namespace roadbalance {

/// vehicle.toml as a request asks for it; all else stays as its user wrote it.
///
/// A channel's range changes with what goes with it: the voltage of the converter (input_range_v), a
/// calibration that the file gives (scale_m_s2_per_count) and the reading at rest (offset_counts).
/// @throws ConfigError naming what cannot be
std::string with_range(const std::string& text, const Request& request);
/// @param channel  of the node, from 0
std::string with_calibration(const std::string& text, const NodeConfig& node, int channel,
                             const TurnOver::Calibration& calibration);
/// The datum of the wheel that the request names by its place.
std::string with_datum(const std::string& text, const Request& request);
std::string with_filter(const std::string& text, const Request& request);
/// @param readings  of each node that is to be zeroed, by its number: no fault
std::string with_zero(const std::string& text, const std::map<int, StandstillReadings::Reading>& readings);

}  // namespace roadbalance
