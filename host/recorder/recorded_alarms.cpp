#include "host/recorder/recorded_alarms.hpp"

#include <algorithm>

#include "common/record/record.hpp"

namespace roadbalance {

void RecordedAlarms::take(const Note& note) {
  if (!is_alarm_cause(note.a)) return;  // a later version's
  const Alarm alarm = alarm_of(note.a, note.b);
  if (note.kind == NoteKind::kAlarmBegan)
    all_.push_back({.alarm = alarm, .began_us = note.time_us, .ended_us = std::nullopt, .text = note.text});
  if (note.kind != NoteKind::kAlarmEnded) return;
  const auto begun = std::find_if(all_.rbegin(), all_.rend(),
                                  [&](const RecordedAlarm& known) { return known.alarm == alarm; });
  if (begun == all_.rend() || begun->ended_us) return;
  begun->ended_us = note.time_us;
  begun->text = note.text;  // what it has come to is in it
}

std::string sentence(const RecordedAlarm& alarm) {
  const std::string place = place_of(alarm.alarm);
  const std::string text =
      alarm.ended_us ? alarm.text : alarm.text + (alarm.text.empty() ? "" : "; ") + "no end is recorded";
  return std::string(word(level_of(alarm.alarm.cause))) + (place.empty() ? "" : " " + place) + ": " +
         name_of(alarm.alarm.cause) + (text.empty() ? "" : " (" + text + ")");
}

std::vector<RecordedAlarm> recorded_alarms(const std::filesystem::path& folder) {
  RecordReader reader(folder);
  reader.finish();
  RecordedAlarms found;
  while (const auto event = reader.next())
    if (event->channel == kNoteChannel)
      if (const auto note = decode_note(event->data)) found.take(*note);
  return found.all();
}

}  // namespace roadbalance
