#pragma once

#include <concepts>
#include <optional>
#include <vector>

#include "host/analysis/identify/estimate.hpp"

namespace roadbalance {

/// Covariance of a whole estimate by the delete-one jackknife over groups of sections: what one more or one
/// fewer stretch of road changes.  It holds every random cause - road, noise, encoder, and the way errors of
/// the suspension and the tyre go into the unbalance - but no common cause such as a wrong wheel mass.
///
///     C = (n - 1) / n  sum_g (x_(g) - mean)(x_(g) - mean)'
///
/// Source: B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, SIAM 1982, ch. 3.
///
/// @param left_out  the estimates with one group left out each, at least two
template <int Size>
Eigen::Matrix<double, Size, Size> jackknife_covariance(
    const std::vector<Eigen::Matrix<double, Size, 1>>& left_out) {
  Eigen::Matrix<double, Size, 1> mean = Eigen::Matrix<double, Size, 1>::Zero();
  for (const auto& x : left_out) mean += x;
  const auto n = static_cast<double>(left_out.size());
  mean /= n;
  Eigen::Matrix<double, Size, Size> covariance = Eigen::Matrix<double, Size, Size>::Zero();
  for (const auto& x : left_out) covariance += (x - mean) * (x - mean).transpose();
  return covariance * ((n - 1.0) / n);
}

/// The same from the groups' sums.
///
/// @param groups  at least two, none of them empty; their sum, by +=, is the whole drive
/// @param solve   from a sum to an estimate
/// Returns nothing if there are fewer, or if a part of the drive does not determine the unknowns.
template <typename Sum, typename Solve>
requires requires(const Sum& sum, const Solve& solve) {
  { solve(sum) } -> std::convertible_to<std::optional<UnknownVector>>;
}
std::optional<UnknownMatrix> jackknife_covariance(const std::vector<Sum>& groups, const Solve& solve) {
  if (groups.size() < 2) return std::nullopt;
  std::vector<UnknownVector> left_out;
  for (std::size_t out = 0; out < groups.size(); ++out) {
    Sum rest;
    for (std::size_t g = 0; g < groups.size(); ++g)
      if (g != out) rest += groups[g];
    const std::optional<UnknownVector> x = solve(rest);
    if (!x) return std::nullopt;
    left_out.push_back(*x);
  }
  return jackknife_covariance(left_out);
}

/// 95 % quantile of chi^2 with two degrees of freedom, -2 ln 0.05: half axes of an ellipse squared, in units
/// of the eigenvalues of its covariance.
inline constexpr double kChiSquared95 = 5.991464547107979;

/// By how much a 95 % ellipse with the axes sqrt(kChiSquared95 eig C) must be widened, as a variance, because
/// C was taken from n groups and not from very many: Hotelling's T^2 in place of chi^2, n > 2.
///
/// Source: H. Hotelling, The generalization of Student's ratio, Ann. Math. Statist. 2 (1931) 360-378.
double few_groups_factor(double groups);

/// The same where only the size of C, not its form, was taken from n drives, in both its components: the
/// quantile of F(2, 2 (n - 1)) in place of chi^2.
///
/// @param drives  n; fewer than two count as two, for below that the uncertainty has no bound
double few_drives_factor(double drives);

}  // namespace roadbalance
