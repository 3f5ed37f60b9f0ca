#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/types/clocks.hpp"
#include "firmware/readout_clock.hpp"

namespace roadbalance {

/// An instant of the board's timer and of the machine's clock at once.
struct BoardInstant {
  std::uint64_t ticks = 0;
  NodeTime time{};
};

/// The board was asked for its time: its timer stood at `ticks` at some instant between the two.
struct BoardExchange {
  std::uint64_t ticks = 0;
  NodeTime asked{}, answered{};

  NodeClock::duration half_round_trip() const noexcept { return (answered - asked) / 2; }
  /// Right within half the round trip.
  BoardInstant instant() const noexcept { return {ticks, asked + half_round_trip()}; }
};

/// Gives what the board stamped with its timer the time of the machine's clock, in which the node lives:
/// scans and edges by one and the same line.
///
/// Begins at the time of an exchange with the board, then follows the arrival of packets, which are only ever
/// late: see ReadoutClock.  The delay of the fastest of them shows in further exchanges and is taken off:
/// their mean, each weighted by the square of its largest error.  Between the packets time runs evenly.
/// Handling a packet late, however long, does not move it.  Never allocates.
class BoardClock {
 public:
  /// A run begins.  @param tick_hz  of the timer, nominal
  BoardClock(double tick_hz, BoardInstant begin) noexcept;

  /// False: nothing stamped so can have arrived then; the stamp is wrong.
  bool is_possible(BoardInstant latest) const noexcept;

  /// A packet arrived whose latest content was stamped so.
  void hear(BoardInstant latest) noexcept;

  /// The board reported its time, since the last packet that was received.  Takes effect with the next one.
  void compare(const BoardExchange& exchange) noexcept;

  NodeTime time(std::uint64_t ticks) const noexcept;

  /// Between two ticks of the timer by the machine's clock: as measured since the run began, nominal at
  /// first.
  double tick_s() const noexcept;

 private:
  /// By how much an exchange's time can be wrong at the board's time `ticks`.
  double wrong_ns(const BoardExchange& exchange, std::uint64_t ticks) const noexcept;
  std::span<const BoardExchange> exchanges() const noexcept;
  double exchanged_tick_s() const noexcept;
  double lateness_ns() const noexcept;

  static constexpr std::size_t kExchanges = 16;

  /// Behind `to_`, in ticks; negative: before it.
  double ticks_behind(std::uint64_t ticks) const noexcept {
    return static_cast<double>(static_cast<std::int64_t>(ticks - to_.ticks));
  }

  ReadoutClock line_;
  double nominal_s_;
  BoardInstant begin_;
  BoardInstant heard_;  ///< end of the line of arrivals
  std::array<BoardExchange, kExchanges> exchange_{};
  std::size_t exchanges_ = 0;  ///< so far
  double taken_off_ns_ = 0.0;
  BoardInstant to_;  ///< end of the piece of the times' line that is in force
  double tick_ns_;   ///< its slope
};

}  // namespace roadbalance
