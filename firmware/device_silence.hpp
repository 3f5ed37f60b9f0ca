#pragma once

#include <chrono>
#include <optional>

#include "common/clock/clocks.hpp"

namespace roadbalance {

/// Whether a device that should give scans all the time gives none, by its own clock.
///
/// A device may take a moment to begin, and scans may be on their way: a second is no silence.  Nor is time
/// in which nobody asked, as of a process that was not scheduled: several reads have to have been in vain.
class DeviceSilence {
 public:
  static constexpr NodeClock::duration kOrdinary = std::chrono::seconds(1);

  /// A read has returned, at `now` by the device's clock, with scans or without.
  void asked(NodeTime now, bool gave_scans) noexcept {
    in_vain_ = gave_scans ? 0 : in_vain_ + 1;
    if (gave_scans || !asked_) heard_ = now;
    asked_ = now;
  }
  /// When a read returned last; nothing: none has.
  std::optional<NodeTime> asked() const noexcept { return asked_; }
  /// It is not there.
  bool is_long() const noexcept { return in_vain_ >= kReadsInVain && *asked_ - heard_ > kOrdinary; }

 private:
  static constexpr int kReadsInVain = 3;  // of 100 ms at most, so that a second has ten

  std::optional<NodeTime> asked_;
  NodeTime heard_{};  ///< a read returned with scans, or the first one did
  int in_vain_ = 0;   ///< reads since
};

}  // namespace roadbalance
