#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <system_error>

#include "common/types/clocks.hpp"

namespace roadbalance {

/// Decides what follows from a failed write or sync, and when the disk is tried again; a pure state machine.
///
/// After one failure the disk is tried at once; after a second one within ten seconds it is failing, and is
/// tried once a second until all that waits is on it.
class FailurePolicy {
 public:
  struct Decision {
    bool is_full = false;         ///< there is no space, or a quota allows no more
    bool has_no_place = false;    ///< nothing lies at the paths any more, or something else
    bool lets_go = false;         ///< nothing stays open on the disk
    bool is_reported = false;     ///< it is one of the first two in a row
    bool goes_elsewhere = false;  ///< to the fallback folder, if there is one
  };
  Decision fail(const std::system_error& error, WallTime now);
  /// Another disk takes its place, or this is the last chance: it may be tried now.
  void retry(WallTime now) { next_try_ = now; }
  /// All that waited is on the disk.  @return whether more than one attempt had failed before
  bool succeed();

  bool is_failing() const { return is_failing_; }
  bool may_try(WallTime now) const { return now >= next_try_; }
  std::int64_t failures() const { return failures_; }
  /// The last one, in words.
  const std::string& why() const { return why_; }

 private:
  bool is_failing_ = false;
  std::optional<WallTime> failed_at_;
  WallTime next_try_ = WallTime::min();
  std::int64_t failures_ = 0;
  int failures_in_a_row_ = 0;
  std::string why_;
};

}  // namespace roadbalance
