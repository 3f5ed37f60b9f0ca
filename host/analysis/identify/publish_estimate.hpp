#pragma once

#include <Eigen/Core>

#include "common/bus/results.hpp"
#include "host/analysis/identify/estimate.hpp"
#include "host/analysis/identify/unbalance_posterior.hpp"

namespace roadbalance {

/// Into the message: springs, dampers, stabilisers and tyres with their standard deviations.
void put_suspension(const UnknownVector& x, const UnknownVector& sigma, Identification& result);

/// An unbalance, and the weight opposite to it, at balance.weight_radius_m.
/// @param unbalance_kg_m     (cos, sin) components
/// @param covariance_kg2_m2  of them
void put_unbalance(const Eigen::Vector2d& unbalance_kg_m, const Eigen::Matrix2d& covariance_kg2_m2,
                   Balance& balance);

/// The unbalance alone, the tyre's force, and whether the speeds separate them.
/// @param widened  factor of the covariances
void put_first_order(const WheelFirstOrder& wheel, double widened, Balance& balance);

}  // namespace roadbalance
