#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/state_filter.hpp"
#include "common/link/blocks.hpp"
#include "firmware/encoder/wheel_encoder.hpp"

namespace roadbalance {

/// Wheel angles -> channels 13 .. 16: sin and cos of both wheels, as the accelerations have them after their
/// anti-aliasing filter, so that no later stage corrects phase.
///
/// sin and cos are computed at twice the scan rate or more and pass a digital copy of the filter of
/// vehicle.toml (ramp-invariant, exact between samples up to their curvature); its value at the scan instant
/// is the reference, 1.0 = kFullScaleCounts.  While an angle is unknown the filter gets zeros and the
/// reference is 0 and flagged, as it is afterwards until the filter has settled.  A line without an encoder
/// is flagged always.  Never allocates after construction.
class Reference {
 public:
  Reference(const VehicleConfig& vehicle, const NodeConfig& node);

  /// Edges in order of time; those of a line that no wheel uses are ignored.
  void add(const Edge& edge) noexcept;

  /// The instant up to which edges must have come before references up to `last` are at their best.
  NodeTime complete_at(NodeTime last) const noexcept;

  /// Looks up the angles for `scans` scans from `first` on.  True if those of all encoders are known.
  bool locate(NodeTime first, int scans) noexcept;

  /// Fills channels 12 .. 15 of the scans located last and returns their Quality bits.
  /// @param after_jump  scans before these are missing: the filter starts from rest
  std::int32_t fill(std::span<std::array<std::int32_t, kChannels>> scans, bool after_jump) noexcept;

  bool has_encoder(int line) const noexcept { return encoder_[static_cast<std::size_t>(line)].has_value(); }
  const WheelEncoder& encoder(int line) const noexcept { return *encoder_[static_cast<std::size_t>(line)]; }

 private:
  static constexpr int kMaxSteps = 32;  ///< a scan
  using Angles = std::array<double, static_cast<std::size_t>(kScansPerBlock* kMaxSteps)>;

  const int steps_;           ///< of the filter in a scan
  const double period_ns_;    ///< between scans
  const int settling_scans_;  ///< until the filter has forgotten a jump of its input
  StateFilter filter_;        ///< rows sin0 cos0 sin1 cos1
  std::array<std::optional<WheelEncoder>, kEncoderLines> encoder_;
  std::array<Angles, kEncoderLines> angle_rad_{};
  std::array<bool, kEncoderLines> known_{}, uncertain_{};
  std::array<int, kEncoderLines> unsettled_{};  ///< scans still to come
};

}  // namespace roadbalance
