#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>

#include "common/types/block.hpp"

namespace roadbalance {

/// How well the angles of a scan block are known, in scan_block_t.quality above its Quality bits: 5 bits for
/// each line, of line 0 bits 6 .. 10, of line 1 bits 11 .. 15.  0: that is not given; n: the standard
/// deviation of an angle is at most 0.001 degrees 2^((n - 1) / 2), half an octave a step up to 32 degrees.
/// Datum and steering angle are not in it.
inline constexpr int kAngleSigmaBits = 5;
inline constexpr std::int32_t kMostAngleSigma = (1 << kAngleSigmaBits) - 1;
inline constexpr double kLeastAngleSigma_rad = 0.001 * std::numbers::pi / 180.0;

constexpr int angle_sigma_place(int line) {
  return kQualityBits + kAngleSigmaBits * line;
}

/// `quality` with the standard deviation of the angle of the wheel on `line`, rounded up; for one beyond 32
/// degrees, or none that is a number, nothing is given.
inline std::int32_t with_angle_sigma(std::int32_t quality, int line, double sigma_rad) noexcept {
  const std::int32_t others = quality & ~(kMostAngleSigma << angle_sigma_place(line));
  if (!(sigma_rad >= 0.0)) return others;
  // A hair less, so that what was read is written the same.
  const double steps = 2.0 * std::log2(std::max(sigma_rad / kLeastAngleSigma_rad, 1.0)) - 1e-9;
  if (!(steps < kMostAngleSigma)) return others;
  const std::int32_t code = 1 + static_cast<std::int32_t>(std::ceil(steps));
  return code > kMostAngleSigma ? others : others | (code << angle_sigma_place(line));
}

/// Nothing if it is not given.
inline std::optional<double> angle_sigma_rad(std::int32_t quality, int line) noexcept {
  const std::int32_t code = (quality >> angle_sigma_place(line)) & kMostAngleSigma;
  if (code == 0) return std::nullopt;
  return kLeastAngleSigma_rad * std::exp2(0.5 * (code - 1));
}

}  // namespace roadbalance
