#pragma once

#include <cstdint>
#include <vector>

#include "common/angle/local_fit.hpp"

namespace roadbalance {

/// Two-sided estimate of a wheel's motion from a stretch of its teeth: position, speed, acceleration driven
/// by white jerk; Kalman filter forwards, Rauch-Tung-Striebel smoother backwards (Rauch, Tung, Striebel,
/// Maximum likelihood estimates of linear dynamic systems, AIAA J. 3, 1965).
///
/// The strength of the jerk is the most likely of a few, from the innovations; it sets the bandwidth, about
/// 3 to 45 Hz, so that torsional motion is followed where there is any and jitter averaged where there is
/// not. A point far off is no tooth and is passed over.
class AngleSmoother {
 public:
  /// @param points  at least LocalFit::kLeastPoints, in order of time
  /// @param noise   variance of the position of one tooth, pitches^2, > 0
  /// False if they show no motion.
  [[nodiscard]] bool smooth(const std::vector<WheelPoint>& points, double noise);

  /// Position at an instant between the first and the last point, pitches.
  double position(std::int64_t time_ns) const;
  /// Standard deviation of position() there, by the model; pitches.
  double sigma(std::int64_t time_ns) const;
  /// Frequency above which the estimate does not follow.
  double bandwidth_hz() const { return bandwidth_hz_; }

 private:
  struct Smoothed {
    std::int64_t time_ns;
    double position, speed_per_s, variance;
  };
  std::size_t before(std::int64_t time_ns) const;

  std::vector<Smoothed> smoothed_;
  double bandwidth_hz_ = 0.0;
};

}  // namespace roadbalance
