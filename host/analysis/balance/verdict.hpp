#pragma once

#include "common/bus/compensation.hpp"
#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// Permissible residual unbalance U = 9549 G m / n, g mm.
///
/// Source: ISO 21940-11:2016, 6.2: e_per Omega = G, with n in 1/min.
/// @param grade_mm_s  G; @param mass_kg of the rotor; @param turns_per_min > 0
double permissible_unbalance_g_mm(double grade_mm_s, double mass_kg, double turns_per_min);

/// True if the unbalance could as well be none: it lies inside its own 95 % ellipse.  Then a weight is as
/// likely to do harm as good.
/// @param balance  state kNone
bool within_own_uncertainty(const Balance& balance);

/// Weights will not cure a force or an unbalance that is beyond its limit by two standard deviations, nor a
/// force that would be left of what turns with the wheel.  Where the unbalance may be none, only the first is
/// reported.
///
/// @param balance  state kNone
/// @param rotor_mass_kg, rolling_radius_m  of the wheel
BalanceVerdict judge_balance(const Balance& balance, const WeightPlan& plan, double rotor_mass_kg,
                             double rolling_radius_m, const BalanceLimits& limits = {});

}  // namespace roadbalance
