#pragma once

#include <array>
#include <string>

#include "common/bus/compensation.hpp"
#include "common/bus/results.hpp"
#include "common/bus/weight_check.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// A drive and its estimate.
struct BalancedDrive {
  std::string name;  ///< of its recording
  VehicleConfig vehicle;
  std::array<Balance, kWheels> balance;
  std::array<Compensation, kWheels> compensation;
};

/// Why angles and grams of a wheel in two drives are not of one kind: another car, encoder, place of its zero
/// mark, or mass; empty: they are.
std::string why_not_comparable(const VehicleConfig& before, const VehicleConfig& after, int wheel);

/// True if [[wheel.weight]] of the two have different weights on some wheel, and every wheel compares.
bool weights_were_fitted_between(const VehicleConfig& before, const VehicleConfig& after);

/// Effect of fitted weights: a drive before beside one after.
///
/// Which weights those were is in [[wheel.weight]] of the two vehicle.toml; where both are the same,
/// those that were advised after the drive before.  The unbalance must have changed by what they are. Whether
/// it did is judged by chi^2 of two degrees of freedom at 99 %, with both drives' covariances and kFitting of
/// the weights for their place and mass; then whether it changed not at all, as if the angle had been counted
/// the wrong way round, or as if they had been fitted at the heavy spot.
std::array<WeightCheck, kWheels> check_weights(const BalancedDrive& before, const BalancedDrive& after);
inline constexpr double kFitting =
    0.05;  ///< share of a weight by which it is elsewhere or lighter than stated

/// While the drive before is read: nothing is known.
/// @param now  of the drive after, for which this stands
std::array<WeightCheck, kWheels> reading_before(const std::string& name,
                                                const std::array<Balance, kWheels>& now);

}  // namespace roadbalance
