#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/state_filter.hpp"
#include "common/types/blocks.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// Angles of both encoder lines -> channels 13 .. 16: their sin and cos as the accelerations have them after
/// their anti-aliasing filter.
///
/// sin and cos are computed at the scan rate, or so often in a scan that it is 4 kHz, and pass a digital copy
/// of the filter of vehicle.toml (ramp-invariant, exact between samples up to their curvature); its value at
/// the scan instant is the reference, 1.0 = kFullScaleCounts.  While an angle is unknown the filter gets
/// zeros and the reference is 0 and flagged, as it is afterwards until the filter has settled.  Never
/// allocates after construction.
class ReferenceFilter {
 public:
  static constexpr int kMostSteps = 32;  ///< a scan
  /// The angles of one line at all steps of some scans; empty: not known.
  using Angles = std::array<std::span<const double>, kEncoderLines>;

  ReferenceFilter(const FilterConfig& filter, double rate_hz);

  /// Steps end at a scan: the first lies one step after the scan before.
  NodeTime first_step(NodeTime first_scan) const noexcept;
  double step_ns() const noexcept { return period_ns_ / steps_; }
  double period_ns() const noexcept { return period_ns_; }
  int steps(int scans) const noexcept { return scans * steps_; }

  /// Fills channels 12 .. 15 of the scans and returns their quality_no_reference bits.
  /// @param after_jump  scans before these are missing: the filter starts from rest
  std::int32_t fill(std::span<std::array<std::int32_t, kChannels>> scans, const Angles& angle_rad,
                    bool after_jump) noexcept;

 private:
  const int steps_;                             ///< in a scan
  const double period_ns_;                      ///< between scans
  const int settling_scans_;                    ///< until the filter has forgotten a jump of its input
  StateFilter filter_;                          ///< rows sin0 cos0 sin1 cos1
  std::array<int, kEncoderLines> unsettled_{};  ///< scans still to come
};

}  // namespace roadbalance
