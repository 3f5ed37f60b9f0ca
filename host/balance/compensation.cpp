#include "host/balance/compensation.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>

#include "host/balance/verdict.hpp"
#include "host/balance/weight_plan.hpp"

namespace roadbalance {

bool within_own_uncertainty(const Balance& balance) {
  constexpr double kChiSquared95 = 5.991464547107979;  // two degrees of freedom: -2 ln 0.05
  const Eigen::Vector2d unbalance_g =
      balance.unbalance_g * Eigen::Vector2d(std::cos(balance.angle_rad), std::sin(balance.angle_rad));
  return unbalance_g.dot(balance.covariance_g2.ldlt().solve(unbalance_g)) <= kChiSquared95;
}

Compensation compensate(const Balance& balance, const WheelConfig& wheel, const BalanceLimits& limits) {
  Compensation result{.wheel = balance.wheel,
                      .time_ns = balance.time_ns,
                      .radii = static_cast<std::int32_t>(wheel.stock.radius_m.size())};
  if (balance.state != Unknown::kNone) return result;
  const bool uncertain = within_own_uncertainty(balance);
  // Of no unbalance the plan is to keep what is fitted.
  const auto unbalance_g_m =
      uncertain ? 0.0 : std::polar(balance.unbalance_g * balance.weight_radius_m, balance.angle_rad);
  result.plan = plan_weights(unbalance_g_m, wheel.stock, wheel.fitted);
  const bool touches = std::ranges::any_of(
      result.plan.step, [](const WeightStep& step) { return step.action != WeightAction::kKeep; });
  result.advice = uncertain ? Advice::kLeaveUncertain : touches ? Advice::kSteps : Advice::kLeaveSmall;
  result.verdict = judge_balance(balance, result.plan, wheel.mass_kg, wheel.rolling_radius_m, limits);
  return result;
}

}  // namespace roadbalance
