#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/angle/counter_angle.hpp"
#include "common/angle/counter_track.hpp"
#include "common/angle/counter_unwrap.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {

/// A pulse counter on the bus and the zero marks of an encoder line -> wheel angle (conventions.md), live.
///
/// An instant lies between messages, and its angle is better the more come behind it: up to kBehind are worth
/// waiting for.  There is no angle before the first mark of a run of the counter, where messages stay away,
/// where marks contradict one another, and without a zero mark; after a mark that lies elsewhere it is
/// uncertain until the next (CounterAngle).  Changes of the wheel's speed show as slowly as the messages
/// come: torsional motion is not followed.  Never allocates after construction.
class CounterEncoder {
 public:
  static constexpr std::size_t kBehind = CounterTrack::kPoints / 2;

  CounterEncoder(const EncoderConfig& config, const SignalConfig& counter);

  /// An edge of the line: only zero marks count.
  void add(NodeTime time, EdgeKind kind) noexcept;
  /// A message of the counter.
  void add(NodeTime time, double code) noexcept;

  /// As WheelEncoder::angles.
  [[nodiscard]] bool angles(NodeTime first, double step_ns, std::span<double> angle_rad) const noexcept;

  /// Standard deviation of the angle at an instant, all causes but the datum; infinite where it is not known.
  double sigma_rad(NodeTime time) const noexcept;

  /// Messages that come soon determine this instant better.
  bool is_awaited(NodeTime time) const noexcept;

  /// The last mark lay elsewhere than those before it.
  bool uncertain() const noexcept { return angle_.is_uncertain(); }

  /// Times that the count did not go on where it was: messages stayed away for too long, the unit began anew,
  /// or the marks show that it lost counts.
  std::int64_t breaks() const noexcept {
    return unwrap_.counters().ambiguous + unwrap_.counters().implausible + angle_.moved();
  }
  /// CounterAngle::mark_counts.
  std::array<int, 2> mark_counts() const noexcept { return angle_.mark_counts(); }
  /// Marks that lay elsewhere than those before them.
  std::int64_t marks_elsewhere() const noexcept { return angle_.elsewhere(); }

 private:
  static constexpr std::int64_t kSilence_ns = 1'000'000'000;
  void take_marks() noexcept;

  const EncoderConfig config_;
  CounterUnwrap unwrap_;
  CounterTrack track_;
  CounterAngle angle_;
  std::array<std::int64_t, 64> pending_ns_{};  ///< marks whose messages are still to come, in order
  std::size_t pending_marks_ = 0;
};

}  // namespace roadbalance
