#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/bus/notes.hpp"

namespace roadbalance {

/// UTC of a record's stamps where the computer's wall clock was set while it recorded (NoteKind::kClockSet):
/// all that it stamped before, since it was started, is as much later.  Memory is bounded, whatever the
/// record holds.
class SetClocks {
 public:
  /// As an event bears it, with the notes taken before it.
  struct Stamp {
    std::int64_t utc_us = 0;  ///< 0: it has none
    std::size_t notes = 0;
  };

  /// Every note, in the order of the record.
  void take(const Note& note);
  Stamp stamp(std::int64_t utc_us) const { return {utc_us, changes_us_.size()}; }
  /// By all notes taken so far.
  std::int64_t utc_us(const Stamp& stamp) const;

 private:
  static constexpr std::size_t kMost = 10'000;
  std::vector<std::int64_t> changes_us_;  // in order; kBoot: the computer was started anew
  std::int64_t incarnation_ = 0, host_ns_ = 0;
};

}  // namespace roadbalance
