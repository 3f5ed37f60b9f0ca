#pragma once

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"
#include "host/identify/estimate.hpp"
#include "host/identify/moments.hpp"

namespace roadbalance {

/// [wheel x check] what (2) leaves, N times the instrument's unit: 0 in the mean if the model fits.
using CheckResiduals = Eigen::Matrix<double, kWheels, kWheelChecks>;

/// The wheels' equations (2) at lags that the estimate did not use, with the estimate put in, a second of
/// driving.
///
/// A wheel's row is the body's row of its strut on the other side: its springs and dampers were found in
/// proportion to the body's mass, its tyre in proportion to its own.  So the residuals tell the wheel's mass
/// against the body's, and what else keeps one linear car from being all there is.  A common error of all
/// masses they cannot tell: then every force is wrong by the same share.
CheckResiduals check_residuals(const DriveMoments& moments, const UnknownVector& x, const Geometry& geometry,
                               const ParameterVector& known);

/// Misfit of two residuals of one kind.
struct Misfit {
  double square = 0.0;                             ///< r' C^-1 r
  double chance = 1.0;                             ///< that residuals of a model that fits show as much
  double share = 0.0;                              ///< of the cause in question that explains them best
  double sigma_share = 0.0;                        ///< 0: not judged
  Eigen::Vector2d gain = Eigen::Vector2d::Zero();  ///< share = gain . r
};

/// Hotelling's test of two residuals, and what a cause would have to be to explain them.
///
///     share = -(g' C^-1 g)^-1 g' C^-1 r,    (n - 2) / (2 (n - 1)) r' C^-1 r ~ F(2, n - 2)
///
/// Source: H. Hotelling, The generalization of Student's ratio, Ann. Math. Statist. 2 (1931) 360-378.
/// @param per_share  g, by how much the residuals grow with the cause
/// @param groups     n, from which the covariance was taken; below 4 nothing is judged
Misfit judge_misfit(const Eigen::Vector2d& residual, const Eigen::Matrix2d& covariance,
                    const Eigen::Vector2d& per_share, std::size_t groups);

}  // namespace roadbalance
