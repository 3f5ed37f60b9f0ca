#pragma once

#include <concepts>
#include <optional>
#include <vector>

#include "host/identify/estimate.hpp"

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
UnknownMatrix jackknife_covariance(const std::vector<UnknownVector>& left_out);

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

/// Of the moments of a drive; groups without sections are passed over.
std::optional<UnknownMatrix> jackknife_covariance(const std::vector<DriveMoments>& groups,
                                                  const Geometry& geometry, const ParameterVector& known);

}  // namespace roadbalance
