#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

#include "common/clock/clocks.hpp"

namespace roadbalance {

/// Whether a device that should give scans all the time gives none, by its own clock.
///
/// A device may take a moment to begin, and scans may be on their way: a second is no silence.  Nor is time
/// in which nobody asked, as of a process that was not scheduled: a read waits no longer than kLongestRead.
class DeviceSilence {
 public:
  static constexpr NodeClock::duration kOrdinary = std::chrono::seconds(1);

  /// A read has returned, at `now` by the device's clock, with scans or without.
  void asked(NodeTime now, bool gave_scans) noexcept {
    const auto waited = asked_ ? std::min(now - *asked_, kLongestRead) : NodeClock::duration{};
    in_vain_ = gave_scans ? NodeClock::duration{} : in_vain_ + waited;
    asked_ = now;
  }
  /// When a read returned last; nothing: none has.
  std::optional<NodeTime> asked() const noexcept { return asked_; }
  /// It is not there.
  bool is_long() const noexcept { return in_vain_ > kOrdinary; }

 private:
  static constexpr NodeClock::duration kLongestRead = std::chrono::milliseconds(100);

  std::optional<NodeTime> asked_;
  NodeClock::duration in_vain_{};  ///< reads since one gave scans
};

}  // namespace roadbalance
