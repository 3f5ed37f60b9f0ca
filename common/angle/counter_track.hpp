#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/config/counter_form.hpp"

namespace roadbalance {

/// Where a counter stood at an instant, in pulses since the run began, with its uncertainty.
struct CounterPosition {
  double pulses = 0.0;
  double rate_hz = 0.0;
  double random_sigma = 0.0;   ///< pulses: rounding, jitter and what the fit did not follow
  double latency_sigma = 0.0;  ///< pulses: the mean latency; the same way at all instants of one speed
};

/// The position of a counter between its messages.
///
/// A quadratic in time by least squares through the kPoints messages about the instant (n pulses: the wheel
/// is at n + 1/2 step on average, for a counter rounds down).  Motion faster than the messages, such as the
/// wheel's torsional motion at wheel hop, is neither in it nor in its uncertainty.
class CounterTrack {
 public:
  static constexpr std::size_t kPoints = 9;

  /// @param step  the counter moves by multiples of this
  /// @throws std::invalid_argument for a negative sigma or jitter or a step below 1
  CounterTrack(const CounterLatency& latency, std::int64_t step);

  /// A count that CounterUnwrap gave, the younger after the older; another run forgets those before.
  void add(std::int64_t time_ns, std::int64_t count, std::int64_t run) noexcept;

  /// @return nothing unless the instant lies between messages of one run and there are enough of them
  std::optional<CounterPosition> at(std::int64_t time_ns) const noexcept;

  /// Messages that came behind an instant; all that are remembered if it lies before them.
  std::size_t behind(std::int64_t time_ns) const noexcept;
  /// The instant of the youngest message; the smallest number there is if none came.
  std::int64_t newest_ns() const noexcept;

  std::int64_t run() const noexcept { return run_; }

 private:
  static constexpr std::size_t kKept = 64;
  struct Point {
    std::int64_t time_ns;  ///< at which the counter had that count
    double pulses;
  };
  const Point& point(std::size_t n) const noexcept { return points_[n % kKept]; }

  CounterLatency latency_;
  double step_;
  std::int64_t run_ = 0;
  std::array<Point, kKept> points_{};
  std::size_t taken_ = 0;
};

}  // namespace roadbalance
