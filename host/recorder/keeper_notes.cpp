#include <algorithm>
#include <array>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "host/recorder/record_keeper.hpp"

namespace roadbalance {
namespace {

// Not that a recorder runs, which one that is started again and again would say in as many segments, nor what
// it has chosen to delete: that stays until it is said.
bool is_news(NoteKind kind) {
  return kind != NoteKind::kStarted && kind != NoteKind::kTailCut && kind != NoteKind::kSegmentDeleted;
}

}  // namespace

// Devices fail, alarms flap and people ask for as long as a disk fails: those notes alone have no bound of
// their own.
bool RecordKeeper::has_memory_for(NoteKind kind) {
  constexpr std::array kRecurring{NoteKind::kDevice, NoteKind::kAsked, NoteKind::kAlarmBegan,
                                  NoteKind::kAlarmEnded};
  if (std::ranges::find(kRecurring, kind) == kRecurring.end()) return true;
  if (notes_held_ < kMostHeldNotes) {
    ++notes_held_;
    return true;
  }
  ++notes_dropped_;
  return false;
}

void RecordKeeper::declare_dropped(std::int64_t count, const char* what) {
  if (count == 0) return;
  const std::string lost = std::to_string(count) + " " + what + " were not kept: no memory for more";
  note(NoteKind::kDiskFailed, 0, writer_->segment(), lost);
  warnings_.push_back(lost);
}

void RecordKeeper::note(NoteKind kind, std::int64_t a, std::int64_t b, std::string text,
                        std::chrono::nanoseconds age) {
  if (!has_memory_for(kind)) return;
  Note note = stamp_;
  note.time_us -= age.count() / 1000;
  note.host_ns -= age.count();
  note.kind = kind;
  note.a = a;
  note.b = b;
  note.text = std::move(text);
  if (kind == NoteKind::kMark) last_mark_ = a;
  has_news_ = has_news_ || is_news(kind);
  held_.push(kNoteChannel, encode(note), stamp_.time_us);
}

}  // namespace roadbalance
