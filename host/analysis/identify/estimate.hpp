#pragma once

#include <bitset>
#include <optional>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/moments.hpp"

namespace roadbalance {

/// Everything that a drive determines, as one vector so that its covariance is one matrix:
/// spring[4], damper[4], stabiliser[2], tyre[4], then unbalance Re U, Im U of each wheel, kg m.
enum Unknowns : int {
  kEstimatedSpring = 0,
  kEstimatedDamper = 4,
  kEstimatedStabiliser = 8,
  kEstimatedTyre = 10,
  kEstimatedUnbalance = 14,
  kUnknowns = 22,
};
using UnknownVector = Eigen::Matrix<double, kUnknowns, 1>;
using UnknownMatrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

/// Places in UnknownVector; both parts of an unbalance together.
using UnknownSet = std::bitset<kUnknowns>;
UnknownSet suspension_unknowns();  ///< springs, dampers and stabilisers, all ten
std::bitset<kWheels> wheels_asked_for_unbalance(const UnknownSet& asked);

/// Into x; those of wheels asked for and not found are NaN.
void put_unbalances(const Eigen::Vector4cd& unbalance, const std::bitset<kWheels>& found,
                    const UnknownSet& asked, UnknownVector& x);

/// Step 1 alone: springs, dampers, stabilisers from each body row of (2) for each instrument.
using SuspensionVector = Eigen::Matrix<double, kEstimatedTyre, 1>;
std::optional<SuspensionVector> solve_suspension(const DriveMoments& moments, const Geometry& geometry,
                                                 const ParameterVector& known);

/// Solves the moments of a drive, in two steps:
///
/// 1. Springs, dampers and stabilisers from the body's rows of (2) by least squares over all instruments;
///    body mass and inertias are known and fix the scale.
/// 2. With the suspension known: the angle references as instruments give U, linear in the tyre stiffnesses;
///    each wheel's own past acceleration as instrument gives one equation for ct with that U.  The wheels'
///    masses are known and fix the scale.
///
/// Unknowns not asked for are as known; an unbalance not asked for is 0 (any suspension asked for: all of
/// it). Wheels without a reference have NaN as unbalance, and their ct is found as if they were balanced.
/// From BodyMoments there are the unbalances alone, the rest is NaN.
/// Returns nothing if the drive does not determine the suspension, or what the body alone shows.
///
/// Source: covariance method, relation (2) of moments.hpp with positive lags in place of the unknown C_yu.
std::optional<UnknownVector> solve(const DriveMoments& moments, const Geometry& geometry,
                                   const ParameterVector& known,
                                   const UnknownSet& asked = UnknownSet().set());

}  // namespace roadbalance
