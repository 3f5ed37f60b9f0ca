#pragma once

#include <string>

#include "common/bus/notes.hpp"

namespace roadbalance {

/// Whether a note of the original goes into the new recording.
enum class NoteUse {
  kIfWanted,   ///< if its instant is wanted: marks, alarms and the like
  kAlways,     ///< it describes the original's own source, or a loss
  kOnceBegun,  ///< once the first piece has begun: a pair of clocks
  kNever,      ///< it is about the original's files, or its recorder
};
NoteUse use_of(const Note& note);

/// The losses counted since `before`; counts of an epoch only rise.
NodeLosses losses_since(const NodeLosses& before, const NodeLosses& now);

}  // namespace roadbalance
