#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace roadbalance {

/// Variance of an estimate from groups of unequal weight, by the delete-m_j jackknife: what leaving out whole
/// drives changes, a long one by more than a short one.
///
///     h_j = sum m / m_j,  pseudo_j = h_j x - (h_j - 1) x_(j),  J = g x - sum (1 - 1/h_j) x_(j),
///     variance = 1/g sum (pseudo_j - J)^2 / (h_j - 1)
///
/// Source: F. M. T. A. Busing, E. Meijer, R. van der Leeden, Delete-m jackknife for unequal m, Statistics and
/// Computing 9 (1999) 3-8.
/// @param whole     the estimate from all
/// @param left_out  [unknown x group] without that group
/// @param weight    m_j > 0 of each group, two at least
Eigen::VectorXd unequal_jackknife_variance(const Eigen::VectorXd& whole, const Eigen::MatrixXd& left_out,
                                           const Eigen::VectorXd& weight);

}  // namespace roadbalance
