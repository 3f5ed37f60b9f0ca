#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "common/types/clocks.hpp"

namespace roadbalance {

/// How long the disk will do, when to warn, and when it is full; a pure state machine.
///
/// The last `reserve_bytes` are not for measuring: they hold what is under way when credit stops.  A disk
/// that refuses a write although there is space (a quota) is full for a second at least, and until it has
/// taken a write.
class SpaceWatch {
 public:
  enum class Event { kNone, kWarning, kFull, kFree };

  explicit SpaceWatch(std::int64_t reserve_bytes) : reserve_bytes_(reserve_bytes) {}

  /// @param free_bytes  on the disk; negative: not known, which changes nothing
  /// @param recorded_bytes  in this run: gives the rate
  Event take(std::int64_t free_bytes, std::int64_t recorded_bytes, WallTime now);
  /// A write found no space.
  Event refuse(WallTime now);
  /// All that waited is on the disk.
  void wrote() { refuses_ = false; }

  bool full() const { return full_; }
  /// Beyond the reserve, never negative.
  std::int64_t usable_bytes() const;
  /// At the rate of the last minute; negative: not known.
  double seconds_left() const { return seconds_left_; }

 private:
  bool crosses_a_warning();

  struct Sample {
    WallTime at{};
    std::int64_t bytes = 0;
  };
  const std::int64_t reserve_bytes_;
  std::deque<Sample> samples_;  // of recorded_bytes, a second apart, over the last minute
  std::int64_t usable_bytes_ = 0;
  double seconds_left_ = -1;
  int warnings_ = 0;  // given since there was enough: for 60, 15 and 5 minutes
  bool full_ = false;
  std::optional<WallTime> refused_at_;
  bool refuses_ = false;  // no write has succeeded since
};

}  // namespace roadbalance
