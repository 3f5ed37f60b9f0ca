#pragma once

#include <array>
#include <cstdint>

#include "common/angle/pitch_table.hpp"

namespace roadbalance {

/// Where the teeth of a wheel are, in pitches: the table counts once the zero mark has shown which tooth is
/// which.
struct ToothGrid {
  PitchTable table;
  bool located = false;
  std::int64_t origin = 0;  ///< number of the tooth nearest to a zero mark

  double position(std::int64_t number) const noexcept {
    return static_cast<double>(number) + (located ? table.error_pitches(number - origin) : 0.0);
  }
};

/// Gives every pulse the number of its tooth: predicts the angle with the present speed, the nearest tooth
/// wins, a pulse more than 0.42 of a pitch from it is dropped.  A missing tooth is simply absent.  Where
/// stamps jitter so much that they leave that gate, the next pulse is the next tooth though it is 0.65 of a
/// pitch off.
///
/// The prediction is a critically damped g-h filter in pitches (E. Brookner, Tracking and Kalman Filtering
/// Made Easy, Wiley, 1998, ch. 1).  Its memory is as long as torsional motion of the wheel allows, so that it
/// bears as much jitter as it can: it lags 0.1 of a pitch behind 1 degree at 13 Hz.
class ToothTracker {
 public:
  explicit ToothTracker(int teeth);

  enum class Outcome {
    kStarting,  ///< not yet enough pulses for a speed
    kStarted,   ///< a run begins: starting() holds its first teeth
    kNumbered,  ///< the pulse is tooth number()
    kReplaces,  ///< nearer to tooth number() than the pulse before, which was no tooth
    kDropped,   ///< belongs to no tooth
    kLost,      ///< pulses stopped or make no sense: a new run begins
  };
  Outcome add(std::int64_t time_ns, const ToothGrid& grid) noexcept;

  static constexpr int kStart = 8;  ///< pulses from which the first speed is taken
  const std::array<NumberedTooth, kStart>& starting() const noexcept { return first_; }

  bool running() const noexcept { return running_; }
  std::int64_t number() const noexcept { return number_; }
  /// Teeth jumped over by the pulse numbered last.
  std::int64_t missed() const noexcept { return missed_; }
  /// Stamps of late were so far from their teeth that jitter can put one out of its gate.
  bool jitters() const noexcept;
  double position(std::int64_t time_ns) const noexcept;
  /// Time a pitch takes at the present speed.  Needs running().
  double pitch_ns() const noexcept { return 1.0 / state_.speed_per_ns; }

  /// No pulse has come for so long that the number of one at this time would be a guess.  Needs running().
  bool too_long(std::int64_t time_ns) const noexcept;
  void forget() noexcept;

  /// Without a pulse for so long, the wheel counts as standing.
  static constexpr std::int64_t kStandstill_ns = 100'000'000;

 private:
  struct State {
    std::int64_t time_ns = 0;
    double position = 0.0;      ///< pitches
    double speed_per_ns = 0.0;  ///< pitches per nanosecond
  };
  Outcome collect(std::int64_t time_ns) noexcept;
  void number_first_pulses() noexcept;
  void count_fault(bool fault) noexcept;

  const int teeth_;
  const double longest_memory_ns_;
  double memory_pitches_ = 0.0;  ///< grows from the start of a run
  bool running_ = false;
  int collected_ = 0;
  std::array<NumberedTooth, kStart> first_{};
  State state_, before_;
  std::int64_t number_ = 0, number_before_ = 0, missed_ = 0;
  std::int64_t in_step_from_ = 0;  ///< number from which the next pulse is expected to be the next tooth
  double distance_ = 0.0;          ///< of the pulse numbered last from its tooth
  double distance_square_ = 0.0;   ///< mean of late, pitches^2
  int dropped_ = 0;                ///< since the last numbered pulse
  double faults_ = 0.0;            ///< pulses missing or dropped of late: a third of them means a false speed
};

}  // namespace roadbalance
