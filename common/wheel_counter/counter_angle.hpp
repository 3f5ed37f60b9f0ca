#pragma once

#include <cstdint>
#include <optional>

#include "common/wheel_counter/counter_track.hpp"
#include "common/wheel_counter/counter_unwrap.hpp"

namespace roadbalance {

/// The same form with limits that suit a wheel's ring: no wheel turns faster than 45 times a second (300
/// km/h) or gains more than 12 turns a second in one.
CounterForm of_ring(CounterForm form, std::int64_t pulses_per_turn);

/// Angle of a wheel from its pulse counter on the bus and a zero mark of its own (a sensor of ours on the
/// wheel: the bus sends none).
///
/// Where the mark lies among the pulses of a turn is the circular mean over all marks of the counter's run.
/// Once kSettled agree, one that lies elsewhere is false, doubled or late and does not count; as many in a
/// row are right, for the control unit lost counts, and the mean begins anew. Without a mark there is no
/// angle, only an angle turned through.
class CounterAngle {
 public:
  struct Angle {
    double angle_rad = 0.0;  ///< 0 .. 2 pi from the zero mark
    double sigma_rad = 0.0;  ///< of all causes that CounterTrack and the scatter of the marks tell
  };

  /// Marks further from their mean than this are not of one turn: the number of pulses is wrong or counts
  /// were lost by the control unit.
  static constexpr double kWidestMark_pulses = 2.0;
  static constexpr int kSettled = 8;

  /// @throws std::invalid_argument if pulses_per_turn < 1
  explicit CounterAngle(std::int64_t pulses_per_turn);

  /// A zero mark passed; `track` must know the instant, that is, messages behind it have come.
  /// @return false if it could not be used
  [[nodiscard]] bool mark(std::int64_t time_ns, const CounterTrack& track) noexcept;

  /// @return nothing unless the track knows the instant and a mark of the same run was seen, and if the marks
  ///         contradict one another
  std::optional<Angle> at(std::int64_t time_ns, const CounterTrack& track) const noexcept;

  std::int64_t marks() const noexcept { return marks_; }
  /// Standard deviation of one mark about their mean, pulses.
  double scatter_pulses() const noexcept;

 private:
  double pulses_;  ///< of a turn
  bool is_false(double phase) const noexcept;
  double expected_pulses() const noexcept;

  std::int64_t run_ = 0, marks_ = 0;
  int false_in_a_row_ = 0;
  double cosine_ = 0.0, sine_ = 0.0;  ///< sums over the marks
  double random2_ = 0.0;              ///< sum of the marks' random variance, pulses^2
  double latency_rate_hz_ = 0.0;      ///< sum of the rates at which they passed
};

}  // namespace roadbalance
