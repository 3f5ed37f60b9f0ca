#pragma once

namespace roadbalance {

/// Standard acceleration of free fall (3rd General Conference on Weights and Measures, 1901): "g" as a unit,
/// and the reading of a sensor at rest to 0.3 %.
inline constexpr double kStandardGravity_m_s2 = 9.80665;

}  // namespace roadbalance
