#include "tools/views/alarm_lines.hpp"

#include <array>
#include <utility>

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

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
  for (const ActiveAlarm& on : active)
    lines.push_back(shape(level_of(on.alarm.cause)) + (" " + sentence_of(on.alarm, on.text)));
  return lines;
}

Json alarm_json(const Alarm& alarm, const std::string& text) {
  return {{"level", word(level_of(alarm.cause))},
          {"where", place_of(alarm)},
          {"what", name_of(alarm.cause)},
          {"text", text}};
}

Json recorded_alarms_json(const std::vector<RecordedAlarm>& alarms) {
  Json list = Json::array();
  for (const RecordedAlarm& one : alarms) {
    Json of = alarm_json(one.alarm, one.text);
    of["began_us"] = one.began_us;
    of["ended_us"] = one.ended_us ? Json(*one.ended_us) : Json();
    list.push_back(std::move(of));
  }
  return list;
}

std::string coloured(const std::string& line) {
  for (const auto& [level, code] : kColours)
    if (const std::size_t at = line.find(head(level)); at <= 2) return code + line + "\033[0m";
  return line;
}

}  // namespace roadbalance
