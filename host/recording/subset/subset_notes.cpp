#include "host/recording/subset/subset_notes.hpp"

#include <algorithm>

namespace roadbalance {

NoteUse use_of(const Note& note) {
  if (tells_of_loss(note)) return NoteUse::kAlways;  // the time of the loss is unknown
  switch (note.kind) {
    case NoteKind::kSubset:
    case NoteKind::kSubsetEpoch:
    case NoteKind::kImported:
      return NoteUse::kAlways;
    case NoteKind::kClock:
      return NoteUse::kOnceBegun;
    case NoteKind::kStarted:
    case NoteKind::kStopped:
    case NoteKind::kSegmentAbandoned:
    case NoteKind::kSegmentDeleted:
    case NoteKind::kTailCut:
    case NoteKind::kFallback:
    case NoteKind::kEndContradicts:
    case NoteKind::kStopping:
      return NoteUse::kNever;
    default:
      return NoteUse::kIfWanted;
  }
}

NodeLosses losses_since(const NodeLosses& before, const NodeLosses& now) {
  NodeLosses since = now;
  NodeLosses::list_counts([](const char*, auto& count, auto less) { count -= less; }, since, before);
  return since;
}

}  // namespace roadbalance
