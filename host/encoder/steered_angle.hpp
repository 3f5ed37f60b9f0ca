#pragma once

#include <cstddef>
#include <span>

#include "common/wheel_counter/steering_track.hpp"
#include "host/encoder/recorded_angle.hpp"

namespace roadbalance {

/// RecordedAngle of a transducer that is fixed to the body: without what steering adds to it, by the recorded
/// messages on both sides of each instant.  Of a transducer on the wheel's carrier: RecordedAngle unchanged.
class SteeredAngle {
 public:
  /// @param steering  samples of the steering angle, in order of time
  SteeredAngle(const EncoderConfig& config, std::span<const Edge> edges,
               std::span<const SignalSample> steering)
      : angle_(config, edges), ratio_(config.steering_ratio), steering_(steering.size() + 2) {
    for (const SignalSample& sample : steering) steering_.add(to_ns(sample.time), sample.value);
  }

  /// As RecordedAngle::angles.  Where the steering angle is not known uncertain() says so.
  [[nodiscard]] bool angles(NodeTime first, double step_ns, std::span<double> angle_rad) {
    if (!angle_.angles(first, step_ns, angle_rad)) return false;
    if (ratio_ == 0.0) return true;
    unsteered_ = !steering_.take_out(ratio_, to_ns(first), step_ns, angle_rad);
    return true;
  }

  /// The same of the instants of the last call: a faulty turn, or a steering angle that is not known.
  bool uncertain(NodeTime first, NodeTime last) const { return unsteered_ || angle_.uncertain(first, last); }

  /// Standard deviation of an angle of the last call; datum and steering angle are not in it.
  double sigma_rad() const { return angle_.sigma_rad(); }
  const RecordedAngle& encoder() const { return angle_; }

 private:
  RecordedAngle angle_;
  double ratio_;
  SteeringTrack steering_;
  bool unsteered_ = false;
};

}  // namespace roadbalance
