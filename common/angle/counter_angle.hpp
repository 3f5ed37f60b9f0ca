#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/angle/counter_track.hpp"
#include "common/angle/counter_unwrap.hpp"
#include "common/angle/mark_count.hpp"

namespace roadbalance {

/// The same form with limits that suit a wheel's ring: no wheel turns faster than 45 times a second (300
/// km/h) or gains more than 12 turns a second in one.
CounterForm of_ring(CounterForm form, std::int64_t pulses_per_turn);

/// Angle of a wheel from its pulse counter on the bus and a zero mark of its own (a sensor of ours on the
/// wheel: the bus sends none).
///
/// The mark's place among the pulses of a turn is the circular mean over the marks of the counter's run, the
/// last kMemory of them: counts that the unit loses within kWidestMark_pulses are not seen, and fade with
/// these. Once kSettled agree, a mark that lies elsewhere does not count: it may be false, doubled or late,
/// or the control unit has lost counts and the mark is right.  Only the next mark decides: the angle is
/// uncertain after one, there is none after kMostElsewhere in a row, and where kSettled of these agree on
/// another place that is the place.  Without a mark there is no angle, only an angle turned through.
///
/// Where more than kMostATurn marks came a turn of late, a second one lies on the wheel, however near: no
/// place is the mark's, and there is no angle.
class CounterAngle {
 public:
  struct Angle {
    double angle_rad = 0.0;  ///< 0 .. 2 pi from the zero mark
    double sigma_rad = 0.0;  ///< of all causes that show in CounterTrack and in the scatter of the marks
  };

  /// Marks further from their mean than this are not of one turn: the number of pulses is wrong or counts
  /// were lost by the control unit.
  static constexpr double kWidestMark_pulses = 2.0;
  static constexpr int kSettled = 8;
  static constexpr int kMostElsewhere = 2;
  static constexpr int kMemory = 256;
  static constexpr double kMostATurn = 4.0 / 3.0;

  /// @throws std::invalid_argument if pulses_per_turn < 1
  explicit CounterAngle(std::int64_t pulses_per_turn);

  /// A zero mark passed; `track` must reach the instant, that is, messages behind it have come.
  /// @return false if it could not be used
  [[nodiscard]] bool mark(std::int64_t time_ns, const CounterTrack& track) noexcept;

  /// @return nothing unless the track reaches the instant and a mark of the same run was seen, and if the
  ///         marks contradict one another or the place they had before
  std::optional<Angle> at(std::int64_t time_ns, const CounterTrack& track) const noexcept;

  /// The last mark lay elsewhere than those before it.
  bool is_uncertain() const noexcept { return elsewhere_in_a_row_ > 0; }

  /// Marks that lay elsewhere, of all runs.
  std::int64_t elsewhere() const noexcept { return elsewhere_; }
  /// Times that they came to have another place in the same run: the control unit lost counts.
  std::int64_t moved() const noexcept { return moved_; }

  /// Marks do not name a pulse of the turn: the pulses that were counted between them (MarkCount::counts).
  std::array<int, 2> mark_counts() const noexcept;

  std::int64_t marks() const noexcept { return place_.marks; }
  /// Standard deviation of one mark about their mean, pulses.
  double scatter_pulses() const noexcept { return scatter_pulses(place_); }

 private:
  /// Where marks lie: sums over them, the older the less.
  struct Place {
    std::int64_t marks = 0;
    double cosine = 0.0, sine = 0.0;
    double random2 = 0.0;          ///< random variance, pulses^2
    double latency_rate_hz = 0.0;  ///< rates at which they passed

    void add(double phase, const CounterPosition& position) noexcept;
    void fade() noexcept;
  };
  double scatter_pulses(const Place& place) const noexcept;
  static double expected_pulses(const Place& place) noexcept;
  static double widest_pulses(const Place& place) noexcept;
  bool agree(const Place& place) const noexcept { return scatter_pulses(place) <= widest_pulses(place); }
  bool is_elsewhere(double phase) const noexcept;
  bool is_ambiguous() const noexcept;
  void hear_of_another_place(double phase, const CounterPosition& position) noexcept;

  double pulses_;  ///< of a turn
  std::int64_t run_ = 0;
  MarkCount counted_;
  std::array<double, MarkCount::kWindow> late_{};  ///< pulses of the latest marks of the run, in order
  std::size_t late_marks_ = 0;
  Place place_;
  Place other_;  ///< of the marks in a row that lay elsewhere
  int elsewhere_in_a_row_ = 0;
  std::int64_t elsewhere_ = 0, moved_ = 0;
};

}  // namespace roadbalance
