#include <cstdio>

#include "common/bus/alarm.hpp"
#include "common/clock/utc.hpp"
#include "common/text/printable.hpp"
#include "host/recorder/verify.hpp"

namespace roadbalance {
namespace {

std::string number(std::int64_t value) {
  return std::to_string(value);
}

// "ALARM node 1: samples lost"
std::string alarm_text(const Note& note) {
  const bool began = note.kind == NoteKind::kAlarmBegan;
  if (!is_alarm_cause(note.a)) return "alarm " + number(note.a) + (began ? "" : " is over");
  return sentence_of(alarm_of(note.a, note.b)) + (began ? "" : " is over");
}

std::string what_happened(const Note& note) {
  switch (note.kind) {
    case NoteKind::kStarted:
      return "recorder started, from segment " + number(note.a) + " on";
    case NoteKind::kStopped:
      return "recorder stopped as asked";
    case NoteKind::kClock:
      return "clocks";
    case NoteKind::kDiskFailed:
      if (tells_of_loss(note)) return "lost from the recording that this one was made of";
      return "disk failed, error " + number(note.a) + ", in segment " + number(note.b);
    case NoteKind::kSegmentAbandoned:
      return "segment " + number(note.a) + " abandoned: it ends at byte " + number(note.b);
    case NoteKind::kDiskFull:
      return "disk full, " + number(note.a) + " bytes free";
    case NoteKind::kDiskFree:
      return "recording goes on, " + number(note.a) + " bytes free";
    case NoteKind::kFallback:
      return "fallback folder from here on";
    case NoteKind::kPowerLost:
      return "supply lost";
    case NoteKind::kPowerReturned:
      return "supply returned";
    case NoteKind::kSegmentDeleted:
      return "segment " + number(note.a) + " deleted by the retention mode, " + number(note.b) + " bytes";
    case NoteKind::kTailCut:
      return number(note.b) + " bytes behind the last event of segment " + number(note.a) +
             " cut, and kept beside";
    case NoteKind::kPowerUnknown:
      return note.a != 0 ? "whether the supply is there cannot be read" : "the supply can be read again";
    case NoteKind::kDevice:
      return "devices of node " + number(note.a);
    case NoteKind::kEndContradicts:
      return "the blocks received of node " + number(note.a) + " are not those that its end, block " +
             number(note.b) + ", sums up";
    case NoteKind::kMark:
      return "mark " + number(note.a);
    case NoteKind::kAsked:
      return "asked";
    case NoteKind::kExcerpt:
      return note.a == 0 ? "made of another recording" : "part " + number(note.a);
    case NoteKind::kExcerptEpoch:
      return "epoch " + number(note.a) + " is made of epoch " + number(note.b);
    case NoteKind::kImported:
      return "made of another program's samples";
    case NoteKind::kAlarmBegan:
    case NoteKind::kAlarmEnded:
      return alarm_text(note);
    case NoteKind::kDiskLow:
      return "disk full in " + number(note.a) + " s at this rate, " + number(note.b) + " bytes free";
  }
  return "note of kind " + number(static_cast<std::int64_t>(note.kind)) + " (" + number(note.a) + ", " +
         number(note.b) + ")";
}

}  // namespace

std::string note_text(const Note& note) {
  const std::string when = note.time_us != 0 ? utc_text(note.time_us) + " " : "";
  return when + what_happened(note) + (note.text.empty() ? "" : ": " + printable_text(note.text));
}

}  // namespace roadbalance
