#pragma once

#include <optional>

#include "host/analysis/identify/estimators/grouped.hpp"
#include "host/analysis/identify/estimators/relation_covariances.hpp"

namespace roadbalance {

/// Which instruments a wheel's row of (2) uses.  The body's rows always use all.
enum class RelationInstruments {
  kAll,     ///< accelerations of all coordinates, angles of all wheels asked for, road where measured
  kOwn,     ///< the wheel's own acceleration, angle and road
  kAngles,  ///< its angle alone
};

/// Stand-in for H C_yu.
enum class RelationRoad {
  kUnknown,                  ///< unknown for every instrument and lag; lambda_k leads from speed to speed
  kUnknownForAccelerations,  ///< 0 for the angles: they do not depend on the road
  kNone,                     ///< 0: instruments of the past do not depend on the road to come
  kMeasured,
};

struct RelationOptions {
  RelationInstruments instruments = RelationInstruments::kAll;
  RelationRoad road = RelationRoad::kUnknown;
  double road_exponent = 2.0;  ///< w of the road's spectrum, ~ 1 / frequency^w
  /// Divide equations by the mass of their row and the rms of their instrument w'' over all speeds together,
  /// so that all are accelerations; else they stand as they are, force times the instrument's own unit.
  bool scaled = true;
};

/// Least squares of relation (2) over all rows, lags, instruments and speeds, the paper's (25)-(27):
///
///     H C_yz'' M' - H F^-1 C_yz'' P' + H F^-2 C_yz'' Q' - H C_yd T' - H C_yu S' = 0
///
/// linear in all that may be asked: springs, dampers, stabilisers, tyres, unbalances.  With the road not
/// measured H C_yu S' is an unknown of its own for each row, instrument and lag, the same at every speed V_k
/// but for the factor 1 / lambda_k, lambda_k = (V_1 / V_k)^(w - 1); it is eliminated by projection.  A tyre's
/// damping times the road's rate of change, Sd u', is left out: with the road measured the answer is exact
/// for tyres without damping only, and RelationEstimator reports others.
///
/// Columns are scaled to unit norm.
///
/// Returns nothing if the equations do not determine what is asked.  NaN: the unbalance of a wheel without
/// reference.
std::optional<UnknownVector> solve_relation(const BySpeed<RelationCovariances>& sums,
                                            const Question& question, const RelationOptions& options);

}  // namespace roadbalance
