#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/bus/results.hpp"
#include "host/balance/weight_plan.hpp"

namespace roadbalance {

/// What a wheel is judged by.
struct BalanceLimits {
  /// Static unbalance that a shop leaves: balancing machines show less as nothing (usual thresholds 5 .. 7
  /// g).
  double shop_g = 7.0;
  /// ISO 21940-11 (before: ISO 1940-1), table 1: cars, wheels, wheel rims and wheel sets are of grade G 40.
  double grade_mm_s = 40.0;
  /// A wheel that needs more is usually mounted anew, its tyre turned on the rim.
  double heaviest_g = 60.0;
  /// First harmonic of radial force variation at which tyres are usually matched or refused, about 20 lbf.
  double force_n = 90.0;
};

/// Permissible residual unbalance U = 9549 G m / n, g mm.
///
/// Source: ISO 21940-11:2016, 6.2: e_per Omega = G, with n in 1/min.
/// @param grade_mm_s  G; @param mass_kg of the rotor; @param turns_per_min > 0
double permissible_unbalance_g_mm(double grade_mm_s, double mass_kg, double turns_per_min);

struct BalanceVerdict {
  /// Expected rms of what is left after the plan, sqrt(|e|^2 + tr C), at the balance's weight radius.
  double residual_g = 0.0;
  bool within_shop = false;
  double permissible_g = 0.0;  ///< by ISO at the greatest speed driven, at the weight radius
  double grade_mm_s = 0.0;     ///< that the expected residual is of, G
  /// Of the first-order force that is left over the speeds driven to what was there, rms; 1 if unknown.
  double force_left_share = 0.0;
  /// Why weights will not cure this; empty: they will.
  std::string incurable;
};

/// @param balance  state kNone
/// @param rotor_mass_kg, rolling_radius_m  of the wheel
BalanceVerdict judge_balance(const Balance& balance, const WeightPlan& plan, double rotor_mass_kg,
                             double rolling_radius_m, const BalanceLimits& limits = {});

}  // namespace roadbalance
