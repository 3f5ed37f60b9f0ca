#pragma once

#include "common/bus/compensation.hpp"
#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// Plan against a wheel's unbalance with the weights that vehicle.toml has: the plan whose steps
/// leave least of it, or to leave it, and how that is to be judged.
///
/// The unbalance is that of the balance: the equivalent one of the speeds driven, in which a force that does
/// not grow with speed has its share.  Its opposite leaves least of both at those speeds.
///
/// @param wheel  of the balance
/// @throws std::invalid_argument if its stock of weights is none (plan_weights)
Compensation compensate(const Balance& balance, const WheelConfig& wheel, const BalanceLimits& limits);

/// Driving like that so far that still brings the unbalance's standard deviation to the one wanted, s.
///
/// The second part of sigma^2 = fixed^2 + drive^2 falls as one over the time driven; then
/// T (drive^2 / (wanted^2 - fixed^2) - 1) is left of it.  0: it is as well known already; infinite: what no
/// drive lessens is more, or nothing is known yet.
double seconds_wanted(const Balance& balance, double wanted_sigma_g);

}  // namespace roadbalance
