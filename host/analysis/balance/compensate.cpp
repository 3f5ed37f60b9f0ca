#include "host/analysis/balance/compensate.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <set>

#include "host/analysis/balance/verdict.hpp"
#include "host/analysis/balance/weight_plan.hpp"

namespace roadbalance {

namespace {

/// At which weights are or can be.
std::int32_t radii_of(const WheelConfig& wheel) {
  std::set<double> radii_m;
  for (const WeightPlace& place : wheel.stock.place) radii_m.insert(place.radius_m);
  for (const WheelWeight& weight : wheel.fitted) radii_m.insert(weight.place.radius_m);
  return static_cast<std::int32_t>(radii_m.size());
}

}  // namespace

Compensation compensate(const Balance& balance, const WheelConfig& wheel, const BalanceLimits& limits) {
  Compensation result{.wheel = balance.wheel,
                      .time_ns = balance.time_ns,
                      .radii = radii_of(wheel),
                      .wanted_sigma_g = limits.sigma_g,
                      .seconds_wanted = seconds_wanted(balance, limits.sigma_g)};
  if (balance.state != Unknown::kNone) return result;
  const bool uncertain = within_own_uncertainty(balance);
  // Without an unbalance the plan is to keep what is fitted.
  const auto unbalance_g_m =
      uncertain ? 0.0 : std::polar(balance.unbalance_g * balance.weight_radius_m, balance.angle_rad);
  const double deviation_g_m = std::sqrt(balance.covariance_g2.trace()) * balance.weight_radius_m;
  result.plan = plan_weights(unbalance_g_m, deviation_g_m, wheel.stock, wheel.fitted);
  const bool touches = std::ranges::any_of(
      result.plan.step, [](const WeightStep& step) { return step.action != WeightAction::kKeep; });
  result.advice = uncertain ? Advice::kLeaveUncertain : touches ? Advice::kSteps : Advice::kLeaveSmall;
  result.verdict = judge_balance(balance, result.plan, wheel.rotating_mass_kg.value_or(wheel.mass_kg),
                                 wheel.rolling_radius_m, limits);
  result.verdict.by_rotor = wheel.rotating_mass_kg.has_value();
  return result;
}

double seconds_wanted(const Balance& balance, double wanted_sigma_g) {
  const auto square = [](double value) { return value * value; };
  if (balance.state != Unknown::kNone) return std::numeric_limits<double>::infinity();
  if (balance.sigma_g <= wanted_sigma_g) return 0.0;
  const double drive_g2 = square(balance.sigma_drive_g);
  const double room_g2 = square(wanted_sigma_g) - (square(balance.sigma_g) - drive_g2);
  if (room_g2 <= 0.0) return std::numeric_limits<double>::infinity();
  return balance.seconds_used * (drive_g2 / room_g2 - 1.0);
}

}  // namespace roadbalance
