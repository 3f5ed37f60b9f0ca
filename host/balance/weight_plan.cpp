#include "host/balance/weight_plan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kTouch = 0.1;  ///< of a step's moment
/// A fitted weight is where it should be if it is so near, and of the mass it should have.
constexpr double kSamePlace_rad = 3.0 * std::numbers::pi / 180.0;
constexpr double kSameMass_g = 0.5;

void check(const WeightStock& stock) {
  const bool sound = stock.step_g > 0.0 && stock.heaviest_g >= stock.step_g && stock.most >= 1 &&
                     stock.most <= 2 && stock.raster_rad >= 0.0 && stock.length_m_per_g >= 0.0;
  if (!sound || stock.radius_m.empty() || !(*std::ranges::min_element(stock.radius_m) > 0.0))
    throw std::invalid_argument("weights: a stock without radius, or with a number out of its range");
}

double wrap(double angle_rad) {
  const double positive = std::fmod(std::fmod(angle_rad, kTurn) + kTurn, kTurn);
  return positive < kTurn ? positive : 0.0;
}

/// Weights and what they leave of the moment that was wanted.
struct Choice {
  std::vector<WheelWeight> weight;
  double left_g_m = std::numeric_limits<double>::infinity();
};

class Chooser {
 public:
  Chooser(const WeightStock& stock, Complex wanted_g_m) : stock_(stock), wanted_(wanted_g_m) {
    consider({});
    one();
    if (stock.most < 2) return;
    if (stock.raster_rad > 0.0)
      two_on_raster();
    else
      two_anywhere();
  }
  const Choice& best() const { return best_; }

 private:
  /// A touch of a weight costs, so that nobody is sent to clip two where one does nearly as well.
  double cost(const Choice& choice) const {
    return choice.left_g_m +
           kTouch * stock_.step_g * stock_.radius_m.front() * static_cast<double>(choice.weight.size());
  }
  void consider(std::vector<WheelWeight> weights) {
    Complex sum = 0.0;
    for (const WheelWeight& weight : weights) sum += weight.moment_g_m();
    Choice choice{std::move(weights), std::abs(wanted_ - sum)};
    if (!std::isfinite(best_.left_g_m) || cost(choice) < cost(best_)) best_ = std::move(choice);
  }
  double place(double angle_rad) const {
    if (stock_.raster_rad == 0.0) return wrap(angle_rad);
    return wrap(std::round(angle_rad / stock_.raster_rad) * stock_.raster_rad);
  }
  double stocked(double mass_g) const {
    const double most = std::floor(stock_.heaviest_g / stock_.step_g + 1e-9) * stock_.step_g;
    return std::clamp(std::round(mass_g / stock_.step_g) * stock_.step_g, 0.0, most);
  }
  /// The nearest single weight to a moment.
  WheelWeight nearest(Complex moment_g_m, double radius_m) const {
    const double angle_rad = place(std::arg(moment_g_m));
    const double along = (moment_g_m * std::polar(1.0, -angle_rad)).real();
    return {stocked(along / radius_m), angle_rad, radius_m};
  }
  /// Half the angle that two weights need at least between them if they are on one radius.
  double apart_rad(const WheelWeight& a, const WheelWeight& b) const {
    if (a.radius_m != b.radius_m) return 0.0;
    return 0.5 * (a.mass_g + b.mass_g) * stock_.length_m_per_g / a.radius_m;
  }

  void one() {
    for (const double radius_m : stock_.radius_m)
      if (const WheelWeight weight = nearest(wanted_, radius_m); weight.mass_g > 0.0) consider({weight});
  }

  template <typename Use>
  void each_mass(Use use) const {
    for (const double radius_m : stock_.radius_m)
      for (double mass_g = stock_.step_g; mass_g <= stock_.heaviest_g + 1e-9; mass_g += stock_.step_g)
        use(WheelWeight{mass_g, 0.0, radius_m});
  }

  void two_anywhere() {
    const double wanted = std::abs(wanted_);
    if (wanted == 0.0) return;
    each_mass([&](WheelWeight first) {
      each_mass([&](WheelWeight second) {
        const double a = first.mass_g * first.radius_m, b = second.mass_g * second.radius_m;
        if (b > a) return;  // the other way round it comes again
        const auto corner = [&](double own, double other) {
          return std::acos(
              std::clamp((wanted * wanted + own * own - other * other) / (2.0 * wanted * own), -1.0, 1.0));
        };
        double ahead = corner(a, b), behind = corner(b, a);
        if (const double lacking = apart_rad(first, second) - (ahead + behind); lacking > 0.0) {
          ahead += 0.5 * lacking;
          behind += 0.5 * lacking;
        }
        first.angle_rad = wrap(std::arg(wanted_) + ahead);
        second.angle_rad = wrap(std::arg(wanted_) - behind);
        consider({first, second});
      });
    });
  }

  void two_on_raster() {
    const int places = static_cast<int>(std::lround(kTurn / stock_.raster_rad));
    each_mass([&](WheelWeight first) {
      for (int k = 0; k < places; ++k) {
        first.angle_rad = wrap(k * stock_.raster_rad);
        for (const double radius_m : stock_.radius_m) {
          const WheelWeight second = nearest(wanted_ - first.moment_g_m(), radius_m);
          const double between = std::abs(std::remainder(second.angle_rad - first.angle_rad, kTurn));
          if (second.mass_g > 0.0 && between >= apart_rad(first, second) - 1e-9) consider({first, second});
        }
      }
    });
  }

  const WeightStock& stock_;
  Complex wanted_;
  Choice best_;
};

bool at_one_place(const WheelWeight& a, const WheelWeight& b) {
  return a.radius_m == b.radius_m &&
         std::abs(std::remainder(a.angle_rad - b.angle_rad, kTurn)) <= kSamePlace_rad;
}

/// How to come from what is fitted to what is wanted with few touches.
std::vector<WeightStep> steps_between(std::vector<WheelWeight> fitted, std::vector<WheelWeight> wanted) {
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
  match(WeightAction::kKeep,
        [&](const auto& a, const auto& b) { return same_mass(a, b) && at_one_place(a, b); });
  match(WeightAction::kMove, same_mass);
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

}  // namespace

WeightPlan plan_weights(Complex unbalance_g_m, const WeightStock& stock,
                        const std::vector<WheelWeight>& fitted) {
  check(stock);
  std::vector<WeightStep> kept;
  Complex on_wheel = 0.0;
  for (const WheelWeight& weight : fitted) {
    kept.push_back({WeightAction::kKeep, weight, weight});
    on_wheel += weight.moment_g_m();
  }
  if (unbalance_g_m == 0.0) return plan_of(kept);
  std::vector<WeightStep> added = kept;
  const Choice more = Chooser(stock, -unbalance_g_m).best();
  for (const WheelWeight& weight : more.weight)
    added.push_back({WeightAction::kAdd, weight, weight});
  const auto cost = [&](const WeightPlan& plan) {
    const auto touches = std::ranges::count_if(
        plan.step, [](const WeightStep& step) { return step.action != WeightAction::kKeep; });
    return std::abs(plan.residual_g_m(unbalance_g_m)) +
           kTouch * stock.step_g * stock.radius_m.front() * static_cast<double>(touches);
  };
  const WeightPlan adding = plan_of(std::move(added));
  if (fitted.empty()) return adding;
  const WeightPlan anew =
      plan_of(steps_between(fitted, Chooser(stock, on_wheel - unbalance_g_m).best().weight));
  return cost(anew) < cost(adding) ? anew : adding;
}

std::string to_string(const WeightStep& step) {
  const auto degrees = [](double angle_rad) {
    return static_cast<int>(std::lround(angle_rad * 180.0 / std::numbers::pi)) % 360;
  };
  char text[96];
  const WheelWeight& weight = step.weight;
  if (step.action == WeightAction::kMove)
    std::snprintf(text, sizeof text, "move %g g from %d° to %d°", weight.mass_g, degrees(step.from.angle_rad),
                  degrees(weight.angle_rad));
  else
    std::snprintf(text, sizeof text, "%s %g g at %d°",
                  step.action == WeightAction::kAdd      ? "add"
                  : step.action == WeightAction::kRemove ? "remove"
                                                         : "keep",
                  weight.mass_g, degrees(weight.angle_rad));
  return text;
}

}  // namespace roadbalance
