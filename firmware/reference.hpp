#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "common/angle/reference_filter.hpp"
#include "common/angle/steering_track.hpp"
#include "common/angle/wheel_encoder.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/blocks.hpp"
#include "firmware/counter_encoder.hpp"

namespace roadbalance {

/// Faults of an encoder so far.
struct EncoderFaults {
  std::int64_t turns = 0;            ///< that did not have exactly their teeth
  std::int64_t breaks = 0;           ///< of the count of a pulse counter on the bus
  std::int64_t marks_elsewhere = 0;  ///< zero marks of such a counter that lay elsewhere than those before
  std::array<int, 2> mark_counts{};  ///< now: WheelEncoder::mark_counts
};

/// Wheel angles -> channels 13 .. 16: sin and cos of both wheels, as the accelerations have them after their
/// anti-aliasing filter (ReferenceFilter), so that no later stage corrects phase.
///
/// A wheel's teeth come from its line, or from a pulse counter on the node's bus.  The part that steering
/// adds to a transducer that is fixed to the body is taken off by the steering angle of the node's bus; where
/// that is not known the angle is flagged as uncertain.  A line without an encoder is flagged always.  Never
/// allocates after construction.
class Reference {
 public:
  Reference(const VehicleConfig& vehicle, const NodeConfig& node);

  /// Edges in order of time; those of a line that no wheel uses are ignored.
  void add(const Edge& edge) noexcept;
  /// Samples of the node's signals, in order of time for each; those that no angle needs are ignored.
  void add(std::span<const SignalSample> samples) noexcept;

  /// The instant up to which edges must have come before references up to `last` are at their best.
  NodeTime complete_at(NodeTime last) const noexcept;

  /// Looks up the angles for `scans` scans from `first` on.  True if those of all encoders are known, and no
  /// message that comes soon would improve them.
  bool locate(NodeTime first, int scans) noexcept;

  /// Fills channels 12 .. 15 of the scans located last and returns their Quality bits, with how well the
  /// angles are known (angle_sigma.hpp).
  /// @param after_jump  scans before these are missing: the filter starts from rest
  std::int32_t fill(std::span<std::array<std::int32_t, kChannels>> scans, bool after_jump) noexcept;

  bool has_encoder(int line) const noexcept {
    const auto at = static_cast<std::size_t>(line);
    return encoder_[at].has_value() || counter_[at].has_value();
  }
  /// True if the angle of a wheel that has an encoder is not known, by a block's Quality bits.
  bool lacks_angle(std::int32_t quality) const noexcept {
    return (has_encoder(0) && (quality & quality_no_reference(0)) != 0) ||
           (has_encoder(1) && (quality & quality_no_reference(1)) != 0);
  }
  EncoderFaults faults(int line) const noexcept;

 private:
  using Angles = std::array<double, static_cast<std::size_t>(kScansPerBlock* ReferenceFilter::kMostSteps)>;
  bool look_up(std::size_t line, NodeTime from, NodeTime last, std::span<double> angle_rad) noexcept;
  std::int32_t fill_known(std::span<std::array<std::int32_t, kChannels>> scans, bool after_jump) noexcept;
  bool steer(std::size_t line, NodeTime from, std::span<double> angle_rad) noexcept;

  ReferenceFilter filter_;
  std::array<std::optional<WheelEncoder>, kEncoderLines> encoder_;
  std::array<std::optional<CounterEncoder>, kEncoderLines> counter_;
  std::array<std::optional<int>, kEncoderLines> counter_signal_;
  std::optional<int> steering_signal_;
  SteeringTrack steering_;
  std::array<double, kEncoderLines> steering_ratio_{};
  std::array<Angles, kEncoderLines> angle_rad_{};
  ReferenceFilter::Angles known_{};  ///< of those, what is known of the scans located last
  std::array<bool, kEncoderLines> uncertain_{};
  std::array<double, kEncoderLines> sigma_rad_{};  ///< of those that are known
};

}  // namespace roadbalance
