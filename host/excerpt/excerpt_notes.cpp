#include "host/excerpt/excerpt_notes.hpp"

#include <algorithm>

namespace roadbalance {

NoteGoes goes(const Note& note) {
  if (tells_of_loss(note)) return NoteGoes::kAlways;  // from where, nothing can tell
  switch (note.kind) {
    case NoteKind::kExcerpt:
    case NoteKind::kExcerptEpoch:
    case NoteKind::kImported:
      return NoteGoes::kAlways;
    case NoteKind::kClock:
      return NoteGoes::kWithIt;
    case NoteKind::kStarted:
    case NoteKind::kStopped:
    case NoteKind::kSegmentAbandoned:
    case NoteKind::kSegmentDeleted:
    case NoteKind::kTailCut:
    case NoteKind::kFallback:
    case NoteKind::kEndContradicts:
      return NoteGoes::kNot;
    default:
      return NoteGoes::kAlong;
  }
}

NodeLosses losses_since(const NodeLosses& before, const NodeLosses& now) {
  NodeLosses since = now;
  since.repaired -= before.repaired;
  since.spool_failures -= before.spool_failures;
  since.scans_refused -= before.scans_refused;
  since.blocks_unsent -= before.blocks_unsent;
  since.acks_refused -= before.acks_refused;
  since.unreferenced_blocks -= before.unreferenced_blocks;
  for (std::size_t k = 0; k < since.encoder_faults.size(); ++k)
    since.encoder_faults[k] -= before.encoder_faults[k];
  for (std::size_t k = 0; k < since.device_counts.size(); ++k)
    since.device_counts[k] -= before.device_counts[k];
  return since;
}

}  // namespace roadbalance
