#pragma once

#include <cstdint>

#include "firmware/board/sine.hpp"

namespace roadbalance::board {

/// Follows a wheel's angle by its encoder's teeth, and begins it at its zero mark.
///
/// A critically damped g-h filter, run at each tooth.  With T the time since the tooth before, x = 2 pi
/// corner T, r = 1 / (1 + x + x^2 / 2 + x^3 / 6) -- e^-x without an exponential, and below 1 for every x --
/// and e = wrap(tooth's angle - predicted):
///
///     predicted = angle + T speed
///     angle     = predicted + (1 - r^2) e
///     speed     = speed + (1 - r)^2 e / T
///
/// Both poles are at r.  A constant speed is followed without an error of the angle.
///
/// Once it follows, a tooth that is missing is numbered past, and a pulse that no tooth can be is dropped.
///
/// Source: E. Brookner, Tracking and Kalman Filtering Made Easy, Wiley, 1998, ch. 1.
class AngleTracker {
 public:
  struct Setup {
    std::uint32_t pulses_per_turn = 0;  ///< >= 4
    std::uint32_t tick_hz = 1;
    float corner_hz = 20.0f;
    bool zero_mark = false;  ///< without: the angle counts from anywhere
  };
  void start(const Setup& setup);

  /// Stamps never fall.
  void tooth(std::uint64_t ticks, bool forward);
  void zero_mark(std::uint64_t ticks);

  /// The angle at an instant at or after the last tooth; 0 is the zero mark.
  Phase angle(std::uint64_t ticks) const { return carried(ticks) + zero_; }

  /// The angle can be relied on: teeth came as predicted, lately, and the zero mark is known.
  bool locked(std::uint64_t ticks) const;

 private:
  static constexpr std::uint32_t kGoodTeeth = 16;  ///< as predicted, before it counts as following

  Phase place(std::int32_t number) const;
  Phase carried(std::uint64_t ticks) const;
  bool follows() const { return good_ >= kGoodTeeth; }
  bool is_overdue(std::uint64_t ticks) const;
  void leave(std::int32_t passed, bool forward);
  void begin(std::uint64_t ticks, Phase measured);
  void nearest(std::uint64_t ticks, Phase predicted, std::int32_t passed, std::int32_t error);
  void filter(std::uint64_t ticks, Phase predicted, std::int32_t error);
  std::int32_t teeth_in(std::int32_t angle) const;
  std::int32_t without(std::int32_t angle, std::int32_t teeth) const;
  std::int32_t wrapped(std::int32_t number) const;

  Setup setup_;
  std::uint64_t step_ = 0;     ///< between teeth, 2^-64 turns
  std::int32_t pitch_ = 0;     ///< the same, 2^-32 turns
  std::int32_t number_ = 0;    ///< tooth passed last, counted forward from the first seen
  std::uint32_t teeth_ = 0;    ///< since begin(), up to 2
  std::uint32_t good_ = 0;     ///< of them as predicted in a row, up to kGoodTeeth
  std::uint64_t ticks_ = 0;    ///< of the last tooth
  Phase phase_ = 0;            ///< there, filtered
  float speed_ = 0.0f;         ///< 2^-32 turns per tick
  Phase zero_ = 0;             ///< added to phase_, so that the zero mark is at 0
  std::uint32_t marks_ = 0;    ///< zero marks that agreed, up to kAveragedMarks
  std::uint32_t strange_ = 0;  ///< zero marks elsewhere in a row
};

}  // namespace roadbalance::board
