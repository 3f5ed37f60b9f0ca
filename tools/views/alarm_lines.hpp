#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/recorder/alarm_log.hpp"
#include "host/recording/recorded_alarms.hpp"

namespace roadbalance {

/// "!!! ALARM: THE DISK IS FULL": by shape and word.
std::string alarm_line(AlarmLevel level, const std::string& text);
/// "!!! ALARM node 1: samples lost (35 samples by now)", the worst first.
std::vector<std::string> alarm_lines(const std::vector<ActiveAlarm>& active);
/// {"level", "where", "what", "text"}
nlohmann::ordered_json alarm_json(const Alarm& alarm, const std::string& text);
/// [{"level", "where", "what", "text", "began_us", "ended_us"}], as in the record.
nlohmann::ordered_json recorded_alarms_json(const std::vector<RecordedAlarm>& alarms);
/// For a terminal: the line, in its level's colour if it is an alarm's.
std::string coloured(const std::string& line);

}  // namespace roadbalance
