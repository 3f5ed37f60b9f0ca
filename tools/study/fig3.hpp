#pragma once

#include "tools/study/study.hpp"

namespace roadbalance {

/// The paper's Fig. 3: errors of tyre stiffness, unbalanced mass and angle of the front left wheel against
/// the number of samples at each of four speeds, for every estimator beside the Cramer-Rao bound.
///
/// 30 g at 0.19 m and 40 degrees on the front left wheel, all else known and balanced.  One drive with the
/// longest record serves the shorter ones.
Study fig3_study();

}  // namespace roadbalance
