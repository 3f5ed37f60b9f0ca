#pragma once

#include <cstdint>
#include <optional>

#include "common/clock/clocks.hpp"

namespace roadbalance {

/// Whether a disk whose writes or syncs fail may be tried again; a pure state machine.
///
/// After one failure at once; after a second within ten seconds the disk is failing, and is tried once a
/// second until all that waits is on it.
class DiskHealth {
 public:
  void fail(WallTime now);
  /// Another disk takes its place, or nobody will ask again: it may be tried now.
  void retry(WallTime now) { next_try_ = now; }
  /// All that waited is on the disk.
  void succeed() { failing_ = false; }

  bool failing() const { return failing_; }
  bool may_try(WallTime now) const { return now >= next_try_; }
  std::int64_t failures() const { return failures_; }

 private:
  bool failing_ = false;
  std::optional<WallTime> failed_at_;
  WallTime next_try_ = WallTime::min();
  std::int64_t failures_ = 0;
};

}  // namespace roadbalance
