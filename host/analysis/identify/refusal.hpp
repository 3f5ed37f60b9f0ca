#pragma once

#include <optional>
#include <string>

#include "host/analysis/identify/estimate.hpp"
#include "host/analysis/identify/estimate_covariance.hpp"

namespace roadbalance {

/// SuspensionConditioning::margin below which an estimate is refused: a perturbation of the size that the
/// residual shows could then move a combination of the unknowns by a third of what all are, and more than
/// first-order covariances show.
inline constexpr double kLeastMargin = 3.0;

/// The place of a stiffness or damper that is further from vehicle.toml than by a factor of two: the drive
/// did not determine it, or vehicle.toml is of another car.  Stabilisers may truly be weak.  Nothing: all are
/// plausible.
std::optional<int> implausible(const UnknownVector& x, const Priors& priors);

/// Why an estimate of the whole car is not to be given, and what a driver can do about it; empty: it may be.
///
/// @param x           the drive's estimate, nothing: it does not determine it
/// @param covariance  of that
std::string refusal(const std::optional<UnknownVector>& x,
                    const std::optional<EstimateCovariance>& covariance, const Priors& priors);

}  // namespace roadbalance
