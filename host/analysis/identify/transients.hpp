#pragma once

#include <Eigen/Core>

namespace roadbalance {

/// Samples that nothing but a steady road shakes: 1, and 0 from 0.25 s before until 0.8 s after one at which
/// the carriers' motion above 8 Hz exceeds five of its robust standard deviations (median of its size /
/// 0.6745): joints and potholes, which a Gaussian road has once in eight minutes of four carriers.
///
/// @param carriers  [channel x samples] vertical accelerations of the wheels' carriers at a steady speed
Eigen::ArrayXd quiet_samples(const Eigen::Ref<const Eigen::MatrixXd>& carriers, double rate_hz);

}  // namespace roadbalance
