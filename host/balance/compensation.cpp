#include "host/balance/compensation.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "host/balance/verdict.hpp"
#include "host/balance/weight_plan.hpp"

namespace roadbalance {

Compensation compensate(const Balance& balance, const WheelConfig& wheel, const BalanceLimits& limits) {
  Compensation result{.wheel = balance.wheel,
                      .time_ns = balance.time_ns,
                      .radii = static_cast<std::int32_t>(wheel.stock.radius_m.size())};
  if (balance.state != Unknown::kNone) return result;
  const bool uncertain = within_own_uncertainty(balance);
  // Of no unbalance the plan is to keep what is fitted.
  const auto unbalance_g_m =
      uncertain ? 0.0 : std::polar(balance.unbalance_g * balance.weight_radius_m, balance.angle_rad);
  const double deviation_g_m = std::sqrt(balance.covariance_g2.trace()) * balance.weight_radius_m;
  result.plan = plan_weights(unbalance_g_m, deviation_g_m, wheel.stock, wheel.fitted);
  const bool touches = std::ranges::any_of(
      result.plan.step, [](const WeightStep& step) { return step.action != WeightAction::kKeep; });
  result.advice = uncertain ? Advice::kLeaveUncertain : touches ? Advice::kSteps : Advice::kLeaveSmall;
  result.verdict = judge_balance(balance, result.plan, wheel.mass_kg, wheel.rolling_radius_m, limits);
  return result;
}

}  // namespace roadbalance
