#pragma once

#include <cstdint>

#include "common/clock/clocks.hpp"
#include "firmware/readout_clock.hpp"

namespace roadbalance {

/// An instant of the board's timer and of the machine's clock at once.
struct BoardInstant {
  std::uint64_t ticks = 0;
  NodeTime time{};
};

/// Gives what the board stamped with its timer the time of the machine's clock, in which the node lives:
/// scans and edges by one and the same line.
///
/// Begins where an exchange with the board said (right within half its round trip), then follows the arrival
/// of packets, which are only ever late: see ReadoutClock.  Between the packets time runs evenly.  Handling
/// a packet late, however long, does not move it.  Never allocates.
class BoardClock {
 public:
  /// A run begins.  @param tick_hz  of the timer, nominal
  BoardClock(double tick_hz, BoardInstant begin) noexcept;

  /// False: nothing stamped so can have arrived then; the stamp is wrong.
  bool is_possible(BoardInstant latest) const noexcept;

  /// A packet arrived whose latest content was stamped so.
  void hear(BoardInstant latest) noexcept;

  NodeTime time(std::uint64_t ticks) const noexcept;

  /// Between two ticks of the timer by the machine's clock: as measured since the run began, nominal at
  /// first.
  double tick_s() const noexcept;

 private:
  /// Behind `to_`, in ticks; negative: before it.
  double ticks_behind(std::uint64_t ticks) const noexcept {
    return static_cast<double>(static_cast<std::int64_t>(ticks - to_.ticks));
  }

  ReadoutClock line_;
  double nominal_s_;
  BoardInstant begin_;
  BoardInstant to_;  ///< end of the piece of the line that is in force
  double tick_ns_;   ///< its slope
};

}  // namespace roadbalance
