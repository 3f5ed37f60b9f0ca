#pragma once

#include <array>
#include <cstdint>

#include "firmware/board/protocol.hpp"

namespace roadbalance::board {

enum class Signal : std::uint8_t { kA = 0, kB = 1, kZero = 2 };

/// The firmware's needs of a board: the thin layer that is written for each one.
///
/// The layer calls Board::scan(), line_change() and update_references() from interrupts that do not interrupt
/// each other, and the rest of Board from the main loop, which they interrupt.  It forwards every edge
/// stamped at or before a conversion before that conversion, in order of time over all lines.
class Hardware {
 public:
  /// Sets converter, ranges, anti-aliasing filters and capture inputs.  False: it failed, the set-up is as
  /// before.
  virtual bool configure(const Configuration& configuration) = 0;

  /// From now on conversions, edges and D/A updates come.  The first conversion is one period from now; as
  /// master each conversion raises SYNC; as follower each conversion follows a rising edge of SYNC.
  virtual void start(StartMode mode) = 0;

  /// When this returns, no interrupt of a run comes any more.
  virtual void stop() = 0;

  virtual bool level(std::size_t line, Signal signal) const = 0;

  /// The D/A of the references, full scale 32767, in the order of the loop-back channels; called within
  /// Board::update_references().
  virtual void write_references(const std::array<std::int16_t, kLoopChannels>& codes) = 0;

  /// The timer that stamps scans and edges.
  virtual std::uint64_t ticks() const = 0;

 protected:
  ~Hardware() = default;
};

}  // namespace roadbalance::board
