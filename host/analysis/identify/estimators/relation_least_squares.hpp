#pragma once

#include <optional>

#include "host/analysis/identify/estimators/grouped.hpp"
#include "host/analysis/identify/estimators/relation_equations.hpp"

namespace roadbalance {

/// Least squares of relation (2) over all rows, lags, instruments and speeds, the paper's (25)-(27):
///
///     H C_yz'' M' - H F^-1 C_yz'' P' + H F^-2 C_yz'' Q' - H C_yd T' - H C_yu S' = 0
///
/// linear in all that may be asked: springs, dampers, stabilisers, tyres, unbalances.  Equations are divided
/// by the mass of their row and the rms of their instrument; columns are scaled to unit norm.  With the road
/// not measured H C_yu S' is unknown, and UnknownRoad solves them.  A tyre's damping times the road's rate of
/// change, Sd u', is left out where the road is measured: the answer is then exact for tyres without damping
/// only, and RelationEstimator reports others.
///
/// Returns nothing if the equations do not determine what is asked.  NaN: the unbalance of a wheel without
/// reference; with the road unknown the stiffness of its tyre, too.
/// @throws std::invalid_argument as UnknownRoad::fit()
std::optional<UnknownVector> solve_relation(const BySpeed<RelationCovariances>& sums,
                                            const Question& question, const RelationOptions& options);

}  // namespace roadbalance
