#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "common/config/vehicle_config.hpp"
#include "common/frontend/front_end.hpp"
#include "firmware/encoder/tooth_history.hpp"
#include "firmware/encoder/tooth_tracker.hpp"

namespace roadbalance {

/// The edges of one encoder line -> wheel angle (common/vehicle/conventions.md), live.
///
/// Zero marks say which tooth is which, a pitch table takes out the ring's errors, and the angle at an
/// instant is a local cubic least-squares fit over about 25 ms of teeth around it.  Before the first zero
/// mark, after pulses stopped and for an encoder without a zero mark there is no angle.  Where teeth are
/// declared lost, or came backwards, there is none until the next zero mark that the wheel passes forward.
/// Driving backwards is recognised by a second track only; without one the angle then runs forward.  Never
/// allocates after construction.
class WheelEncoder {
 public:
  explicit WheelEncoder(const EncoderConfig& config);

  /// Takes an edge at or after the last one.
  void add(NodeTime time, EdgeKind kind) noexcept;

  /// The instant up to which edges must have been added before angles up to `last` are at their best.
  NodeTime complete_at(NodeTime last) const noexcept;

  /// Angles at first + i * step_ns, continuous over the call, not reduced to a turn.
  /// False if the angle is not known at all of these instants from the edges so far.
  [[nodiscard]] bool angles(NodeTime first, double step_ns, std::span<double> angle_rad) const noexcept;

  /// Present speed; 0 while there are no pulses.
  double speed_rad_s(NodeTime now) const noexcept;

  /// The present or the last turn did not have exactly its teeth, or teeth are lost since the last zero mark.
  bool uncertain() const noexcept { return turn_faults_ > 0 || last_turn_faults_ > 0; }
  /// Some instant of [first, last] lay in such a turn, or in the one after it; of what is not long ago.
  bool uncertain(NodeTime first, NodeTime last) const noexcept {
    return to_ns(last) >= doubt_from_ns_ && (uncertain() || to_ns(first) < doubt_to_ns_);
  }
  /// Turns that did not.
  std::int64_t faulty_turns() const noexcept { return faulty_turns_; }
  const PitchTable& pitch_table() const noexcept { return grid_.table; }

 private:
  struct Window {
    std::size_t begin, end;  ///< in history_
  };
  void add_tooth(std::int64_t time_ns) noexcept;
  void add_mark(std::int64_t time_ns) noexcept;
  void locate(std::int64_t time_ns, double position) noexcept;
  void lose() noexcept;
  void declare_lost() noexcept;
  void begin_turn(std::int64_t time_ns) noexcept;
  void refine_mark() noexcept;
  void learn_if_turn_complete() noexcept;
  double half_window_ns() const noexcept;
  std::optional<Window> window(double from_ns, double to_ns) const noexcept;
  bool positions(double first_ns, double step_ns, std::span<double> position) const noexcept;

  const EncoderConfig config_;
  ToothTracker tracker_;
  ToothGrid grid_;
  ToothHistory history_;

  // Zero mark
  bool mark_known_ = false;
  double mark_phase_ = 0.0;  ///< position of the mark less the origin, pitches, -0.5 .. 0.5 and slowly moving
  int mark_weight_ = 0;
  std::int64_t mark_turn_ = 0;          ///< turn of the last mark taken
  std::int64_t suspected_slip_ = 0;     ///< teeth that the last mark was off
  int strange_marks_ = 0;               ///< in a row
  std::int64_t unrefined_mark_ns_ = 0;  ///< not yet in mark_phase_; 0: none

  std::int64_t learned_turn_ = 0;
  // Doubtful turns, from the mark that began the first to the one that ended the last.
  std::int64_t doubt_from_ns_ = std::numeric_limits<std::int64_t>::min(), doubt_to_ns_ = doubt_from_ns_;
  std::int64_t turn_faults_ = 0, last_turn_faults_ = 0, faulty_turns_ = 0;
};

}  // namespace roadbalance
