#include "tools/rb/alarm_lines.hpp"

#include <array>

namespace roadbalance {
namespace {

struct Colour {
  AlarmLevel level;
  const char* code;
};
constexpr std::array kColours{Colour{AlarmLevel::kAlarm, "\033[1;31m"},
                              Colour{AlarmLevel::kWarning, "\033[33m"},
                              Colour{AlarmLevel::kNotice, "\033[36m"}};

std::string head(AlarmLevel level) {
  return std::string(shape(level)) + " " + word(level);
}

}  // namespace

std::string alarm_line(AlarmLevel level, const std::string& text) {
  return head(level) + ": " + text;
}

std::vector<std::string> alarm_lines(const std::vector<ActiveAlarm>& active) {
  std::vector<std::string> lines;
  for (const ActiveAlarm& on : active) {
    const std::string place = place_of(on.alarm);
    lines.push_back(head(level_of(on.alarm.cause)) + (place.empty() ? "" : " " + place) + ": " +
                    name_of(on.alarm.cause) + (on.text.empty() ? "" : " (" + on.text + ")"));
  }
  return lines;
}

nlohmann::ordered_json recorded_alarms_json(const std::vector<RecordedAlarm>& alarms) {
  using Json = nlohmann::ordered_json;
  Json list = Json::array();
  for (const RecordedAlarm& one : alarms)
    list.push_back({{"level", word(level_of(one.alarm.cause))},
                    {"where", place_of(one.alarm)},
                    {"what", name_of(one.alarm.cause)},
                    {"text", one.text},
                    {"began_us", one.began_us},
                    {"ended_us", one.ended_us ? Json(*one.ended_us) : Json()}});
  return list;
}

std::string coloured(const std::string& line) {
  for (const auto& [level, code] : kColours)
    if (const std::size_t at = line.find(head(level)); at <= 2) return code + line + "\033[0m";
  return line;
}

}  // namespace roadbalance
