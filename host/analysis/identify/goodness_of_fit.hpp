#pragma once

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/estimate.hpp"
#include "host/analysis/identify/moments.hpp"

namespace roadbalance {

/// [wheel x check] what (2) leaves, N times the instrument's unit: 0 in the mean if the model fits.
using CheckResiduals = Eigen::Matrix<double, kWheels, kWheelChecks>;

/// The wheels' equations (2) at lags that the estimate did not use, with the estimate put in, a second of
/// driving.
///
/// A wheel's row is the body's row of its strut on the other side: its springs and dampers were found in
/// proportion to the body's mass, its tyre in proportion to its own.  So the residuals show the wheel's mass
/// against the body's, and what else keeps one linear car from being all there is.  A common error of all
/// masses they cannot show: then every force is wrong by the same share.
CheckResiduals check_residuals(const DriveMoments& moments, const UnknownVector& x, const Geometry& geometry,
                               const ParameterVector& known);

/// Goodness of fit of two residuals of one kind.
struct GoodnessOfFit {
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
/// @param groups     n, groups of equal weight that would hold as much as those from which the covariance was
///                   taken; below 4 nothing is judged
GoodnessOfFit goodness_of_fit(const Eigen::Vector2d& residual, const Eigen::Matrix2d& covariance,
                              const Eigen::Vector2d& per_share, double groups);

/// Chance that residuals of a model that fits are in the mean as far from 0 as these, however many they are:
/// each by its own sigma, and the sum of squares judged as of so many independent ones,
///
///     X = (n - 3) / (n - 1)  1/p sum_i r_i^2 / (C_ii + a^2 / p),    k X ~ chi^2(k),
///     k = (tr R)^2 / tr R^2 (n - 5) / (n - 2),
///
/// C the jackknife's covariance, R the same of the scaled residuals; the factors of n are mean and variance
/// of the square of Student's t.  The tail of chi^2 is Wilson's and Hilferty's.
///
/// Sources: M. S. Srivastava, M. Du, A test for the mean vector with fewer observations than the dimension,
/// J. Multivariate Anal. 99 (2008) 386-402; E. B. Wilson, M. M. Hilferty, The distribution of chi-square,
/// Proc. Nat. Acad. Sci. 17 (1931) 684-688.
/// @param residual  p of them
/// @param left_out  [residual x group], without one group each
/// @param groups    n, groups of equal weight that would hold as much; below 8 nothing is judged
/// @param allowed   a, length that is no evidence against the model
double chance_of_residuals(const Eigen::VectorXd& residual, const Eigen::MatrixXd& left_out, double groups,
                           double allowed);

}  // namespace roadbalance
