#pragma once

#include <numbers>

namespace roadbalance {

/// Angles are in radians; people write and read degrees.
inline constexpr double kTurn = 2.0 * std::numbers::pi;       ///< one turn, rad
inline constexpr double kDegree = std::numbers::pi / 180.0;   ///< one degree, rad
inline constexpr double kDegrees = 180.0 / std::numbers::pi;  ///< one radian, degrees

}  // namespace roadbalance
