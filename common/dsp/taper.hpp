#pragma once

#include <Eigen/Core>

namespace roadbalance {

/// A window that is twice continuously differentiable, with its derivatives in time.
struct Taper {
  Eigen::ArrayXd value;   ///< 0 at both ends, 1 in the middle
  Eigen::ArrayXd first;   ///< d/dt, 1/s
  Eigen::ArrayXd second;  ///< d2/dt2, 1/s^2
};

/// Rises by the fifth-order smooth step x^3 (10 - 15 x + 6 x^2) over `fraction` of the length at each end.
///
/// Signals times this taper vanish at both ends with two derivatives, so integration by parts leaves no end
/// terms.
///
/// @param samples   length, >= 2; the ends lie half a sample outside
/// @param fraction  0 < fraction <= 0.5
/// @param step_s    sample distance
Taper c2_taper(Eigen::Index samples, double fraction, double step_s);

}  // namespace roadbalance
