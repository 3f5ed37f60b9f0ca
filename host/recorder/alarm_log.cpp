#include "host/recorder/alarm_log.hpp"

#include <algorithm>
#include <utility>

namespace roadbalance {
namespace {

/// Its text, then how long it lasted.
std::string with(const std::string& text, const std::string& end) {
  return text.empty() ? end : text + "; " + end;
}

std::string in_seconds(WallTime::duration duration) {
  return std::to_string(std::chrono::duration_cast<std::chrono::seconds>(duration).count()) + " s";
}

}  // namespace

std::chrono::seconds AlarmLog::hold(const State& state) {
  constexpr int kMostDoublings = 6;
  return std::min(kHold * (1 << std::min(state.times - 1, kMostDoublings)), kLongestHold);
}

void AlarmLog::raise(const Alarm& alarm, std::string text, WallTime now) {
  if (!state_.contains(alarm) && state_.size() >= kMostAlarms) return;
  State& state = state_[alarm];
  if (!state.is_on) {
    state.is_on = true;
    state.since = now;
    ++state.times;
  }
  state.text = std::move(text);  // it may be more by now
  state.last = now;
}

// The disk may have refused notes for a while: this one bears the time at which it began.
AlarmNote AlarmLog::begin_of(const Alarm& alarm, const State& state, WallTime now) {
  std::string text = state.text;
  if (now - state.since >= std::chrono::seconds(2))
    text += (text.empty() ? "" : ", ") + in_seconds(now - state.since) + " ago";
  return {.began = true, .alarm = alarm, .text = text};
}

std::vector<AlarmNote> AlarmLog::due(WallTime now) {
  std::vector<AlarmNote> notes;
  for (auto& [alarm, state] : state_) {
    if (!state.is_on) continue;
    if (!std::exchange(state.is_noted, true)) notes.push_back(begin_of(alarm, state, now));
    if (now - state.last < hold(state)) continue;
    notes.push_back({.began = false,
                     .alarm = alarm,
                     .text = with(state.text, "it lasted " + in_seconds(state.last - state.since) +
                                                  ", until " + in_seconds(now - state.last) + " ago")});
    state.is_on = state.is_noted = false;
  }
  return notes;
}

std::vector<AlarmNote> AlarmLog::finish(WallTime now) {
  std::vector<AlarmNote> notes = due(now);
  for (auto& [alarm, state] : state_) {
    if (!std::exchange(state.is_on, false)) continue;
    state.is_noted = false;
    notes.push_back({.began = false,
                     .alarm = alarm,
                     .text = with(state.text, "at the end of the recording, " + in_seconds(now - state.last) +
                                                  " after it was seen last; it lasted " +
                                                  in_seconds(state.last - state.since))});
  }
  return notes;
}

std::vector<ActiveAlarm> AlarmLog::active() const {
  std::vector<ActiveAlarm> found;
  for (const auto& [alarm, state] : state_)
    if (state.is_on) found.push_back({alarm, state.text, state.since});
  std::ranges::stable_sort(found, std::ranges::greater{},
                           [](const ActiveAlarm& on) { return level_of(on.alarm.cause); });
  return found;
}

}  // namespace roadbalance
