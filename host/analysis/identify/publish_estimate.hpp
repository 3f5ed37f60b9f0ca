#pragma once

#include <Eigen/Core>

#include "common/bus/results.hpp"
#include "host/analysis/identify/estimate.hpp"
#include "host/analysis/identify/estimate_covariance.hpp"

namespace roadbalance {

/// Into the message: springs, dampers, stabilisers and tyres with their standard deviations.
void put_suspension(const UnknownVector& x, const UnknownMatrix& covariance, Identification& result);

/// Condition, misfit and what the masses seem to be.
void put_covariance(const EstimateCovariance& covariance, Identification& result);

/// An unbalance, and the weight opposite to it, at balance.weight_radius_m.
/// @param unbalance_kg_m     (cos, sin) components
/// @param covariance_kg2_m2  of them
void put_unbalance(const Eigen::Vector2d& unbalance_kg_m, const Eigen::Matrix2d& covariance_kg2_m2,
                   Balance& balance);

/// Whether the speeds separate a force from the unbalance, and both if they do.
void put_first_order(const FirstOrderFit& fit, Balance& balance);

}  // namespace roadbalance
