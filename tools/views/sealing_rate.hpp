#pragma once

#include <cstdint>
#include <optional>

#include "common/bus/control_messages.hpp"

namespace roadbalance {

/// How fast a node fills its memory, from its heartbeats: blocks sealed in a second of its own time.
class SealingRate {
 public:
  void take(const Heartbeat& beat) {
    if (beat.epoch != epoch_ || beat.time_ns < begin_ns_ || beat.next < begin_next_) {
      *this = {};
      epoch_ = beat.epoch;
      begin_ns_ = beat.time_ns;
      begin_next_ = beat.next;
    }
    if (beat.time_ns - begin_ns_ < kWindow_ns) return;
    per_second_ =
        static_cast<double>(beat.next - begin_next_) / (static_cast<double>(beat.time_ns - begin_ns_) * 1e-9);
    begin_ns_ = beat.time_ns;
    begin_next_ = beat.next;
  }

  /// Time until the memory in the heartbeat, ring and spool, is full if recording stops;
  /// nothing if the rate is not known yet or nothing is sealed.
  std::optional<double> seconds_left(const Heartbeat& beat) const {
    if (per_second_ <= 0.0) return std::nullopt;
    return static_cast<double>(beat.ring_capacity - beat.ring_used) / per_second_;
  }

 private:
  static constexpr std::int64_t kWindow_ns = 2'000'000'000;

  std::optional<std::int64_t> epoch_;
  std::int64_t begin_ns_ = 0;
  std::int64_t begin_next_ = 0;
  double per_second_ = 0;
};

}  // namespace roadbalance
