#include "host/analysis/balance/weight_plan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

#include "common/text/format.hpp"
#include "common/types/angle_units.hpp"
#include "host/analysis/balance/weight_choice.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
/// A fitted weight is where it should be if it is so near, and of the mass it should have.
constexpr double kSamePlace_rad = 3.0 * std::numbers::pi / 180.0;
constexpr double kSameMass_g = 0.5;

void check(const WeightStock& stock) {
  const bool sound = stock.step_g > 0.0 && stock.heaviest_g >= stock.step_g && stock.most >= 1 &&
                     stock.most <= 2 && stock.raster_rad >= 0.0 && stock.length_m_per_g >= 0.0;
  if (stock.raster_rad > 0.0 && (stock.raster_rad > kTurn ||
                                 std::abs(std::remainder(kTurn, stock.raster_rad)) > 1e-6 * stock.raster_rad))
    throw std::invalid_argument("weights: a raster that does not divide a turn");
  const auto has_radius = [](const WeightPlace& place) { return place.radius_m > 0.0; };
  if (!sound || stock.place.empty() || !std::ranges::all_of(stock.place, has_radius))
    throw std::invalid_argument("weights: a stock without place, or with a number out of its range");
}

bool at_one_place(const WheelWeight& a, const WheelWeight& b) {
  return a.place == b.place && std::abs(std::remainder(a.angle_rad - b.angle_rad, kTurn)) <= kSamePlace_rad;
}

/// How to come from what is fitted to what is wanted with few touches.
std::vector<WeightStep> steps_between(std::vector<WheelWeight> fitted, std::vector<WheelWeight> wanted,
                                      const WeightStock& stock) {
  std::vector<WeightStep> steps;
  const auto match = [&](WeightAction action, auto alike) {
    for (auto want = wanted.begin(); want != wanted.end();) {
      const auto have = std::ranges::find_if(fitted, [&](const WheelWeight& f) { return alike(f, *want); });
      if (have == fitted.end()) {
        ++want;
        continue;
      }
      // One that is near enough stays where it is.
      steps.push_back({action, action == WeightAction::kKeep ? *have : *want, *have});
      fitted.erase(have);
      want = wanted.erase(want);
    }
  };
  const auto same_mass = [](const WheelWeight& a, const WheelWeight& b) {
    return std::abs(a.mass_g - b.mass_g) < kSameMass_g;
  };
  const std::vector<WheelWeight> all = wanted;
  const auto in_the_way = [&](const WheelWeight& have, const WheelWeight& want) {
    return std::ranges::any_of(all, [&](const WheelWeight& other) {
      return other.angle_rad != want.angle_rad && lies_on(have, other, stock);
    });
  };
  match(WeightAction::kKeep, [&](const auto& have, const auto& want) {
    return same_mass(have, want) && at_one_place(have, want) && !in_the_way(have, want);
  });
  match(WeightAction::kMove, [&](const auto& have, const auto& want) {
    return same_mass(have, want) && have.place.kind == want.place.kind &&
           have.place.kind != WeightKind::kAdhesive;
  });
  for (const WheelWeight& weight : fitted) steps.push_back({WeightAction::kRemove, weight, weight});
  for (const WheelWeight& weight : wanted) steps.push_back({WeightAction::kAdd, weight, weight});
  return steps;
}

WeightPlan plan_of(std::vector<WeightStep> steps) {
  WeightPlan plan{std::move(steps), 0.0};
  for (const WeightStep& step : plan.step) {
    if (step.action == WeightAction::kAdd || step.action == WeightAction::kMove)
      plan.applied_g_m += step.weight.moment_g_m();
    if (step.action == WeightAction::kRemove || step.action == WeightAction::kMove)
      plan.applied_g_m -= step.from.moment_g_m();
  }
  return plan;
}

/// " on the outer flange", " in the inner plane", with the radius where that is not the only one.
std::string on_place(const WeightPlace& place, bool with_radius) {
  const std::string radius = format("%.0f mm", 1e3 * place.radius_m);
  if (place.plane == RimPlane::kNotGiven) return with_radius ? " on " + radius : "";
  const std::string side = place.plane == RimPlane::kInner ? "inner" : "outer";
  return (place.kind == WeightKind::kClip ? " on the " + side + " flange" : " in the " + side + " plane") +
         (with_radius ? " (" + radius + ")" : "");
}

std::string angle(const WheelWeight& weight) {
  return format("%ld°", std::lround(wrap_turn(weight.angle_rad) * 180.0 / std::numbers::pi) % 360);
}

std::string one_that_is_there(const WheelWeight& weight) {
  switch (weight.place.kind) {
    case WeightKind::kNotGiven:
      return format("%g g", weight.mass_g);
    case WeightKind::kClip:
      return format("the %g g clip", weight.mass_g);
    case WeightKind::kAdhesive:
      return format("the %g g adhesive weight", weight.mass_g);
  }
  return "";
}

const char* putting(WeightKind kind) {
  switch (kind) {
    case WeightKind::kNotGiven:
      return "add";
    case WeightKind::kClip:
      return "clip";
    case WeightKind::kAdhesive:
      return "stick";
  }
  return "";
}

}  // namespace

WeightPlan plan_weights(Complex unbalance_g_m, double deviation_g_m, const WeightStock& stock,
                        const std::vector<WheelWeight>& fitted) {
  check(stock);
  if (!(deviation_g_m >= 0.0)) throw std::invalid_argument("weights: a deviation less than 0");
  std::vector<WeightStep> kept;
  Complex on_wheel = 0.0;
  for (const WheelWeight& weight : fitted) {
    kept.push_back({WeightAction::kKeep, weight, weight});
    on_wheel += weight.moment_g_m();
  }
  if (unbalance_g_m == 0.0) return plan_of(kept);
  std::vector<WeightStep> added = kept;
  for (const WheelWeight& weight : choose_weights(stock, -unbalance_g_m, deviation_g_m, fitted))
    added.push_back({WeightAction::kAdd, weight, weight});
  const auto cost = [&](const WeightPlan& plan) {
    double cost_g_m = expected_g_m(plan.residual_g_m(unbalance_g_m), deviation_g_m);
    for (const WeightStep& step : plan.step)
      if (step.action == WeightAction::kRemove)
        cost_g_m += touch_g_m(stock, deviation_g_m);
      else if (step.action != WeightAction::kKeep)
        cost_g_m += putting_g_m(step.weight, stock, deviation_g_m);
    return cost_g_m;
  };
  const WeightPlan adding = plan_of(std::move(added));
  if (fitted.empty()) return adding;
  const WeightPlan anew = plan_of(
      steps_between(fitted, choose_weights(stock, on_wheel - unbalance_g_m, deviation_g_m, {}), stock));
  return cost(anew) < cost(adding) ? anew : adding;
}

std::string to_string(const WeightStep& step, int radii) {
  const WheelWeight& weight = step.weight;
  const std::string there = " at " + angle(weight) + on_place(weight.place, radii > 1);
  switch (step.action) {
    case WeightAction::kKeep:
      return "keep " + one_that_is_there(weight) + there;
    case WeightAction::kMove:
      return "move " + one_that_is_there(step.from) + " from " + angle(step.from) +
             (step.from.place == weight.place ? "" : on_place(step.from.place, radii > 1)) + " to " +
             angle(weight) + on_place(weight.place, radii > 1);
    case WeightAction::kRemove:
      return "remove " + one_that_is_there(weight) + there;
    case WeightAction::kAdd:
      return putting(weight.place.kind) + format(" %g g", weight.mass_g) + there;
  }
  return "";
}

}  // namespace roadbalance
