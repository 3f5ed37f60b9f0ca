#pragma once

#include <ctime>

#include "common/types/clocks.hpp"

namespace roadbalance {

/// The amount to add to a stamp of another of this machine's clocks to have it in MachineTime.  Both clocks
/// are read as close together as the machine lets: an interruption between two readings would shift the pair,
/// so the narrowest of a few counts; it is within a microsecond on a machine that is not overrun.
///
/// The other clock may be slewed or stepped: ask anew for stamps that come later.  Never allocates.
///
/// @param other  CLOCK_MONOTONIC (kernel stamps of GPIO edges), CLOCK_REALTIME (of datagrams and CAN frames)
inline MachineClock::duration machine_minus(clockid_t other) noexcept {
  auto narrowest = MachineClock::duration::max();
  MachineClock::duration difference{};
  for (int i = 0; i < 20 && narrowest > std::chrono::microseconds(1); ++i) {
    timespec between{};
    const MachineTime before = MachineClock::now();
    clock_gettime(other, &between);
    const MachineTime after = MachineClock::now();
    if (after - before >= narrowest) continue;
    narrowest = after - before;
    difference = (before + narrowest / 2).time_since_epoch() -
                 (std::chrono::seconds(between.tv_sec) + std::chrono::nanoseconds(between.tv_nsec));
  }
  return difference;
}

}  // namespace roadbalance
