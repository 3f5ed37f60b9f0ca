#pragma once

#include <vector>

#include "host/identify/estimate.hpp"

namespace roadbalance {

/// Covariance of the whole estimate by the delete-one jackknife over groups of sections: what one more or one
/// fewer stretch of road changes.  It holds every random cause - road, noise, encoder, and the way errors of
/// the suspension and the tyre go into the unbalance - but no common cause such as a wrong wheel mass.
///
///     C = (n - 1) / n  sum_g (x_(g) - mean)(x_(g) - mean)'
///
/// Source: B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, SIAM 1982, ch. 3.
///
/// @param groups  moments of the groups, at least two that hold sections; their sum is the whole drive
/// Returns nothing if a part of the drive does not determine the unknowns.
std::optional<UnknownMatrix> jackknife_covariance(const std::vector<DriveMoments>& groups,
                                                  const Geometry& geometry, const ParameterVector& known);

}  // namespace roadbalance
