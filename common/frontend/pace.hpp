#pragma once

#include <chrono>
#include <optional>

#include "common/types/clock_pair.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// Time of a drive that is not driven now - simulated or recorded - as the wall clock has it.
class Pace {
 public:
  /// @param rate   seconds of the drive a wall second, > 0
  /// @param start  of the drive
  /// @param slept  how long the computer had been suspended by then (MachineClock::slept()): the drive goes
  /// on
  ///               while it is; nothing: the drive rests then, as the wall clock does
  Pace(double rate, WallTime start, std::optional<MachineClock::duration> slept = {})
      : rate_(rate), start_(start), slept_before_(slept) {}

  /// Seconds since the drive began.
  double drive_s(WallTime now) const {
    return rate_ * std::chrono::duration<double>(now - start_ + slept()).count();
  }
  WallTime wall(double drive_s) const {
    return start_ - slept() +
           std::chrono::duration_cast<WallClock::duration>(std::chrono::duration<double>(drive_s / rate_));
  }
  /// For a drive in real time: nanoseconds since it began at an instant of the machine's clock. It is paced
  /// by CLOCK_MONOTONIC, which is steady_clock and which the system may slew: the two clocks are compared
  /// anew.
  std::int64_t drive_ns(MachineTime machine) const {
    const WallTime wall(machine.time_since_epoch() - machine_minus(CLOCK_MONOTONIC));
    return (wall - start_ + slept()).count();
  }
  double rate() const { return rate_; }
  /// How long the computer was suspended since the drive began; zero of a drive that rests.
  MachineClock::duration slept() const {
    return slept_before_ ? MachineClock::slept() - *slept_before_ : MachineClock::duration{};
  }

 private:
  double rate_;
  WallTime start_;
  std::optional<MachineClock::duration> slept_before_;
};

}  // namespace roadbalance
