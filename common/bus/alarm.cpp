#include "common/bus/alarm.hpp"

#include <array>

namespace roadbalance {
namespace {

struct Named {
  AlarmCause cause;
  const char* name;
};
constexpr std::array kNames{
    Named{AlarmCause::kFallback, "fallback folder in use"},
    Named{AlarmCause::kWheelInStep, "turned in step with another wheel"},
    Named{AlarmCause::kSpoolFailing, "its disk refuses"},
    Named{AlarmCause::kDiskLow, "disk nearly full"},
    Named{AlarmCause::kDiskSlow, "disk slow"},
    Named{AlarmCause::kSupplyGone, "supply gone"},
    Named{AlarmCause::kSupplyUnknown, "supply unknown"},
    Named{AlarmCause::kRivals, "two nodes with one number"},
    Named{AlarmCause::kUnsent, "network refuses"},
    Named{AlarmCause::kClockUnheard, "clock not heard"},
    Named{AlarmCause::kDeadChannel, "no signal"},
    Named{AlarmCause::kRailedChannel, "far off its zero"},
    Named{AlarmCause::kRecorderSays, "recorder"},
    Named{AlarmCause::kClockPoor, "clock known poorly"},
    Named{AlarmCause::kOtherVersion, "another version of the wire"},
    Named{AlarmCause::kAnalyserSilent, "analyser silent"},
    Named{AlarmCause::kNothingRecorded, "nothing is recorded"},
    Named{AlarmCause::kDiskFailing, "disk fails"},
    Named{AlarmCause::kDiskFull, "disk full"},
    Named{AlarmCause::kSamplesLost, "samples lost"},
    Named{AlarmCause::kNodeSilent, "silent"},
    Named{AlarmCause::kNodeFailed, "its device failed"},
    Named{AlarmCause::kOverload, "left its range"},
    Named{AlarmCause::kClockBroken, "clock jumped"},
    Named{AlarmCause::kFaultyTurns, "faulty turns"},
    Named{AlarmCause::kDeviceGone, "a device is gone"},
    Named{AlarmCause::kWrongMarks, "zero marks name no tooth"},
    Named{AlarmCause::kNodeMissing, "does not measure"},
    Named{AlarmCause::kNodeLeftOut, "is not recorded"},
    Named{AlarmCause::kClipped, "clipped"},
};
constexpr std::array kWheelWords{"front left", "front right", "rear left", "rear right"};
constexpr std::int64_t kParts = 100;

}  // namespace

bool is_alarm_cause(std::int64_t number) {
  for (const Named& named : kNames)
    if (static_cast<std::int64_t>(named.cause) == number) return true;
  return false;
}

const char* word(AlarmLevel level) {
  return level == AlarmLevel::kAlarm ? "ALARM" : level == AlarmLevel::kWarning ? "WARNING" : "NOTICE";
}

const char* shape(AlarmLevel level) {
  return level == AlarmLevel::kAlarm ? "!!!" : level == AlarmLevel::kWarning ? " ! " : " i ";
}

const char* name_of(AlarmCause cause) {
  for (const Named& named : kNames)
    if (named.cause == cause) return named.name;
  return "unknown";
}

std::string wrong_marks(std::span<const std::int32_t, 2> counts, std::optional<int> teeth) {
  std::string text = std::to_string(counts[0]);
  if (counts[1] > 0) text += " and " + std::to_string(counts[1]);
  text += " teeth lie between its zero marks";
  if (teeth) text += ", and its ring has " + std::to_string(*teeth);
  return text + ": is a second magnet or the head of a bolt a mark, too, or pulses_per_turn wrong?";
}

std::string place_of(const Alarm& alarm) {
  const std::string node = alarm.node > 0 ? "node " + std::to_string(alarm.node) : "";
  if (alarm.part < 0) return node;
  switch (alarm.cause) {
    case AlarmCause::kWheelInStep: {
      const auto wheel = static_cast<std::size_t>(alarm.part);
      return wheel < kWheelWords.size() ? kWheelWords[wheel] : "wheel " + std::to_string(wheel);
    }
    case AlarmCause::kFaultyTurns:
    case AlarmCause::kWrongMarks:
      return node + " line " + std::to_string(alarm.part + 1);
    default:
      return node + " channel " + std::to_string(alarm.part + 1);
  }
}

std::string sentence_of(const Alarm& alarm, const std::string& text) {
  const std::string place = place_of(alarm);
  return std::string(word(level_of(alarm.cause))) + (place.empty() ? "" : " " + place) + ": " +
         name_of(alarm.cause) + (text.empty() ? "" : " (" + text + ")");
}

std::int64_t place_number(const Alarm& alarm) {
  return std::int64_t{alarm.node} * kParts + alarm.part + 1;
}

Alarm alarm_of(std::int64_t cause, std::int64_t number) {
  return {.cause = static_cast<AlarmCause>(cause),
          .node = static_cast<std::int32_t>(number / kParts),
          .part = static_cast<std::int32_t>(number % kParts) - 1};
}

}  // namespace roadbalance
