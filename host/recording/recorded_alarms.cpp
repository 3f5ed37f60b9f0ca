#include "host/recording/recorded_alarms.hpp"

namespace roadbalance {

void RecordedAlarms::take(const Note& note) {
  clocks_.take(note);
  if (note.kind != NoteKind::kAlarmBegan && note.kind != NoteKind::kAlarmEnded) return;
  if (!is_alarm_cause(note.a)) return;  // a later version's
  const Alarm alarm = alarm_of(note.a, note.b);
  if (note.kind == NoteKind::kAlarmBegan) {
    // The next end belongs to this alarm, even if an earlier one has no end and this one is left out.
    running_.erase(alarm);
    std::size_t& kept = kept_.at(static_cast<std::size_t>(level_of(alarm.cause)) - 1);
    if (kept >= kMostOfALevel) {
      ++left_out_;
      return;
    }
    ++kept;
    running_[alarm] = all_.size();
    all_.push_back({.alarm = {.alarm = alarm, .text = note.text}, .began = clocks_.stamp(note.time_us)});
  } else if (const auto begun = running_.find(alarm); begun != running_.end()) {
    Kept& ended = all_[begun->second];
    ended.ended = clocks_.stamp(note.time_us);
    ended.alarm.text = note.text;  // it has the final amount
    running_.erase(begun);
  }
}

std::vector<RecordedAlarm> RecordedAlarms::all() const {
  std::vector<RecordedAlarm> alarms;
  alarms.reserve(all_.size());
  for (const Kept& kept : all_) {
    RecordedAlarm& alarm = alarms.emplace_back(kept.alarm);
    alarm.began_us = clocks_.utc_us(kept.began);
    if (kept.ended) alarm.ended_us = clocks_.utc_us(*kept.ended);
  }
  return alarms;
}

std::string sentence(const RecordedAlarm& alarm) {
  if (alarm.ended_us) return sentence_of(alarm.alarm, alarm.text);
  return sentence_of(alarm.alarm, alarm.text + (alarm.text.empty() ? "" : "; ") + "no end is recorded");
}

}  // namespace roadbalance
