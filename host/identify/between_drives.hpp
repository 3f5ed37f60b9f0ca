#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace roadbalance {

/// Variance of an estimate by what leaving out whole drives changes, drives counting unequally.
///
///     variance = sum (1 - p_j) (x - x_(j))^2,  p_j = m_j / sum m
///
/// Of a mean of values that scatter as 1 / m_j it has no bias; and as no drive's share is divided by its
/// weight, a light one whose weight is a little wrong does not decide, as it would in the delete-m_j
/// jackknife (of one car on roads of class A, B and C that told 1.7 times too large a variance).
///
/// Source: J. G. MacKinnon and H. White, Some heteroskedasticity-consistent covariance matrix estimators with
/// improved finite sample properties, J. Econometrics 29 (1985) 305-325, HC2, of drives for observations.
/// @param whole     the estimate from all
/// @param left_out  [unknown x group] without that group
/// @param weight    m_j > 0 of each group, two at least
Eigen::VectorXd variance_between(const Eigen::VectorXd& whole, const Eigen::MatrixXd& left_out,
                                 const Eigen::VectorXd& weight);

}  // namespace roadbalance
