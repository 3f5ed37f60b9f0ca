#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/bus/results.hpp"
#include "host/analysis/identify/phase_drift.hpp"
#include "host/analysis/identify/posterior_sums.hpp"
#include "host/analysis/identify/speed_classes.hpp"

namespace roadbalance {

/// One drive's contribution to an estimate from many.
struct DriveSums {
  SpeedClasses classes;
  PosteriorSums posterior;
  PhaseDrift drift;
  std::int64_t time_ns = 0;
  /// Why there are no sections, and what stands in the way besides; kNone: there are some.
  Unknown state = Unknown::kTooShort;
  std::string refusal;
  /// By which a wheel's angle is uncertain all through the drive, rad; 0: no more than its datum.
  std::array<double, kWheels> common_sigma_rad{};

  explicit DriveSums(double speed_class_m_s) : classes(speed_class_m_s) {}
};

/// The same bit for bit in another process of this build.
std::vector<char> encode(const DriveSums& sums);
/// Nothing if the bytes are none of encode().
std::optional<DriveSums> decode_drive_sums(std::span<const char> bytes);

}  // namespace roadbalance
