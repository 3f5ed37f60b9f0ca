#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/types/scan.hpp"

namespace roadbalance {

/// How far a wheel has turned by the speeds on the bus: the integral of straight lines between its messages
/// over the rolling radius.
///
/// It is no angle: its origin is not known, and the radius is wrong by a per cent, so that it runs away
/// by as much.  Over a few dozen turns it shows which orders there are and how large.
class RecordedSpeed {
 public:
  static constexpr std::int64_t kLongestSilence_ns = 500'000'000;

  /// @param speeds    m/s, in order of time
  /// @param radius_m  > 0
  RecordedSpeed(std::span<const SignalSample> speeds, double radius_m);

  /// Turned angles at first + i * step_ns, continuous over the call.  False where there are no messages, or
  /// in two stretches of them.
  [[nodiscard]] bool turned(NodeTime first, double step_ns, std::span<double> angle_rad) const;

  std::int64_t runs() const { return points_.empty() ? 0 : points_.back().run; }

 private:
  struct Point {
    std::int64_t time_ns;
    double speed_rad_s, turned_rad;
    std::int64_t run;  ///< from 1; a silence begins another
  };
  std::vector<Point> points_;
};

}  // namespace roadbalance
