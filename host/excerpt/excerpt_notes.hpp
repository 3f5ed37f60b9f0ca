#pragma once

#include <string>

#include "common/bus/notes.hpp"

namespace roadbalance {

/// What becomes of a note of the original.
enum class NoteGoes {
  kAlong,   ///< if its instant is wanted
  kAlways,  ///< it tells what the original was made of
  kWithIt,  ///< while something is taken: a pair of clocks
  kNot,     ///< it speaks of the original's files, or of its recorder
};
NoteGoes goes(const Note& note);

/// What came on top of what had been counted before; counts of an epoch only rise.
NodeLosses losses_since(const NodeLosses& before, const NodeLosses& now);

}  // namespace roadbalance
