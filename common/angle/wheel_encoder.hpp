#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "common/angle/angle_interpolator.hpp"
#include "common/angle/fault_balance.hpp"
#include "common/angle/mark_count.hpp"
#include "common/angle/pitch_pattern.hpp"
#include "common/angle/tooth_history.hpp"
#include "common/angle/tooth_tracker.hpp"
#include "common/angle/zero_marks.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {

/// The edges of one encoder line -> wheel angle (common/vehicle/conventions.md), live.
///
/// Zero marks show which tooth is which, a pitch table takes out the teeth's errors, and the angle at an
/// instant is a local cubic through the teeth around it (AngleInterpolator).  Before two zero marks have
/// shown that they name one tooth, while they do not (MarkCount), after pulses stopped and for an encoder
/// without a zero mark there is no angle.  Where teeth are declared lost, or came backwards, there is none
/// until the next zero mark that the wheel passes forward, or until the learned errors of the teeth show
/// which is which (PitchPattern), and then it is uncertain. So it is when no mark has come for eight turns.
///
/// The pulse of a tachometer with one a turn is its own zero mark; it must come ten times a second at least
/// (ToothTracker::kStandstill_ns), and the angle is known where three turns before and behind are.
///
/// Without a zero mark the teeth are counted, modulo a turn, from an arbitrary one: no angular location is
/// claimed, and only counted_angles() shows how far the wheel has turned.  The count holds for stamps that
/// jitter by up to a tenth of a pitch with 1 % of the teeth lost and 1 % extra; beyond, and over every hole,
/// it may slip unseen.
///
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

  /// The same without a zero mark: from a tooth that stays the same while count_restarts() does.
  [[nodiscard]] bool counted_angles(NodeTime first, double step_ns,
                                    std::span<double> angle_rad) const noexcept;
  int count_restarts() const noexcept { return count_restarts_; }

  /// Present speed; 0 while there are no pulses.
  double speed_rad_s(NodeTime now) const noexcept;

  /// The present or the last turn did not have exactly its teeth, or teeth are lost since the last zero mark.
  bool uncertain() const noexcept { return turn_faults_ > 0 || last_turn_faulty_; }
  /// Some instant of [first, last] lay in such a turn, or in the one after it; for recent instants only.
  bool uncertain(NodeTime first, NodeTime last) const noexcept {
    return to_ns(last) >= doubt_from_ns_ && (uncertain() || to_ns(first) < doubt_to_ns_);
  }
  /// Turns that did not.
  std::int64_t faulty_turns() const noexcept { return faulty_turns_; }
  /// The zero marks name no tooth, so there is no angle: the teeth counted between them, see
  /// MarkCount::counts.
  std::array<int, 2> mark_counts() const noexcept { return mark_count_.counts(); }
  const PitchTable& pitch_table() const noexcept { return grid_.table; }
  /// Standard deviation of an angle: teeth, smoothing, table and the place of the mark.  Infinite before it
  /// is measured; the datum is not in it.
  double sigma_rad() const noexcept;

 private:
  /// A mark whose place among the teeth is not yet known: those after it are still to come.
  struct PendingMark {
    std::int64_t time_ns;
    std::int64_t faults;  ///< of the turn that it ends
  };
  void add_tooth(std::int64_t time_ns) noexcept;
  void count_faults(std::int64_t time_ns, std::int64_t surplus) noexcept;
  void add_mark(std::int64_t time_ns) noexcept;
  void judge_marks() noexcept;
  void judge(const PendingMark& mark, double position) noexcept;
  void locate(const PendingMark& mark, double position) noexcept;
  void lose() noexcept;
  void declare_lost() noexcept;
  void end_turn(const PendingMark& mark, bool faulty) noexcept;
  void learn_if_turn_complete() noexcept;
  void follow_again() noexcept;
  void forget_teeth() noexcept;
  void find_tooth_again() noexcept;
  void count_from_here() noexcept;
  void found(std::int64_t origin) noexcept;

  const EncoderConfig config_;
  ToothTracker tracker_;
  ToothGrid grid_;
  ToothHistory history_;

  AngleInterpolator interpolator_;

  PitchPattern pattern_;
  std::int64_t next_search_ = 0;  ///< number of the tooth
  int searches_ = 0;              ///< since the teeth were lost
  int count_restarts_ = 0;

  ZeroMarks marks_;
  MarkCount mark_count_;
  std::array<PendingMark, 8> pending_{};
  std::size_t pending_marks_ = 0;

  std::int64_t learned_turn_ = 0;
  // Doubtful turns, from the mark that began the first to the one that ended the last.
  std::int64_t doubt_from_ns_ = std::numeric_limits<std::int64_t>::min(), doubt_to_ns_ = doubt_from_ns_;
  FaultBalance balance_;
  std::int64_t turn_faults_ = 0, faulty_turns_ = 0;
  bool last_turn_faulty_ = false;
};

}  // namespace roadbalance
