#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace roadbalance {

/// The steering wheel's angle between the messages that carry it, and what it adds to a transducer that is
/// fixed to the body (EncoderConfig::steering_ratio, conventions.md).
///
/// A straight line between two messages, the last one's angle after it.  Once kPeriods of the messages before
/// it have passed, kLongest_ns at most, a message is worth nothing: the wheel has turned on.  At 100
/// degrees/s and a ratio of 1/16 that is 0.4 degrees for messages every 20 ms.  How old an angle is when it
/// is sent is not known: 20 ms are 0.13 degrees.  Never allocates after construction.
class SteeringTrack {
 public:
  static constexpr std::int64_t kPeriods = 3, kLongest_ns = 150'000'000;
  /// A bus that was silent for so long is not waited for.
  static constexpr std::int64_t kSilence_ns = 1'000'000'000;

  /// @param kept  so many messages are remembered
  explicit SteeringTrack(std::size_t kept = 256);

  /// A message younger than the last one; others are not used.
  void add(std::int64_t time_ns, double angle_rad) noexcept;

  /// Nothing where no message gives it.
  std::optional<double> at(std::int64_t time_ns) const noexcept;

  /// A message that will come soon determines this instant better than those that came.
  bool is_awaited(std::int64_t time_ns) const noexcept;

  /// Takes `ratio` times the angle off angles at first + i * step_ns.  False if it was not known at all of
  /// these instants: the rest is as if the wheel had been left where it was last known, or never turned.
  [[nodiscard]] bool take_out(double ratio, std::int64_t first_ns, double step_ns,
                              std::span<double> angle_rad) const noexcept;

 private:
  struct Point {
    std::int64_t time_ns;
    double angle_rad;
  };
  const Point& point(std::size_t n) const noexcept { return points_[n % points_.size()]; }
  std::int64_t worth_ns(std::size_t n) const noexcept;

  std::vector<Point> points_;
  std::size_t taken_ = 0;
};

}  // namespace roadbalance
