#include "host/balance/weight_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kTouch = 0.1;  ///< of a step's moment
constexpr double kMass = 0.01;  ///< of the moments of the weights
/// A fitted weight is where it should be if it is so near, and of the mass it should have.
constexpr double kSamePlace_rad = 3.0 * std::numbers::pi / 180.0;
constexpr double kSameMass_g = 0.5;

void check(const WeightStock& stock) {
  const bool sound = stock.step_g > 0.0 && stock.heaviest_g >= stock.step_g && stock.most >= 1 &&
                     stock.most <= 2 && stock.raster_rad >= 0.0 && stock.length_m_per_g >= 0.0;
  if (stock.raster_rad > 0.0 && (stock.raster_rad > kTurn ||
                                 std::abs(std::remainder(kTurn, stock.raster_rad)) > 1e-6 * stock.raster_rad))
    throw std::invalid_argument("weights: a raster that does not divide a turn");
  if (!sound || stock.radius_m.empty() || !(*std::ranges::min_element(stock.radius_m) > 0.0))
    throw std::invalid_argument("weights: a stock without radius, or with a number out of its range");
}

double wrap(double angle_rad) {
  const double positive = std::fmod(std::fmod(angle_rad, kTurn) + kTurn, kTurn);
  return positive < kTurn ? positive : 0.0;
}

/// Angle between two weights that touch, if they are on one radius.
double apart_rad(const WheelWeight& a, const WheelWeight& b, const WeightStock& stock) {
  if (a.radius_m != b.radius_m) return 0.0;
  return 0.5 * (a.mass_g + b.mass_g) * stock.length_m_per_g / a.radius_m;
}

bool lies_on(const WheelWeight& a, const WheelWeight& b, const WeightStock& stock) {
  return std::abs(std::remainder(a.angle_rad - b.angle_rad, kTurn)) < apart_rad(a, b, stock) - 1e-9;
}

/// Weights that leave least of the moment that was wanted.
class Chooser {
 public:
  /// @param staying  weights that stay where they are
  Chooser(const WeightStock& stock, Complex wanted_g_m, const std::vector<WheelWeight>& staying)
      : stock_(stock), wanted_(wanted_g_m), staying_(staying) {
    consider({});
    one();
    if (stock.most < 2) return;
    if (stock.raster_rad > 0.0)
      two_on_raster();
    else
      two_anywhere();
  }
  const std::vector<WheelWeight>& best() const { return best_; }

 private:
  /// A touch of a weight costs, so that nobody is sent to clip two where one does nearly as well, and of what
  /// leaves as much that of little mass is best.
  void consider(std::span<const WheelWeight> weights) {
    Complex sum = 0.0;
    double cost = 0.0;
    for (const WheelWeight& weight : weights) {
      sum += weight.moment_g_m();
      cost += kTouch * stock_.step_g * stock_.radius_m.front() + kMass * weight.mass_g * weight.radius_m;
    }
    cost += std::abs(wanted_ - sum);
    if (cost >= least_cost_) return;
    least_cost_ = cost;
    best_.assign(weights.begin(), weights.end());
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
  bool is_free(const WheelWeight& weight) const {
    return std::ranges::none_of(staying_, [&](const auto& other) { return lies_on(weight, other, stock_); });
  }
  /// The weight where it is, or on either side of those that stay, nothing where there is no room.
  std::vector<WheelWeight> beside_staying(const WheelWeight& weight) const {
    if (is_free(weight)) return {weight};
    std::vector<WheelWeight> places;
    for (const WheelWeight& other : staying_)
      for (const double side : {-1.0, 1.0}) {
        WheelWeight moved = weight;
        double angle_rad = other.angle_rad + side * apart_rad(weight, other, stock_);
        if (const double raster = stock_.raster_rad; raster > 0.0)
          angle_rad = side * std::ceil(side * angle_rad / raster - 1e-6) * raster;
        moved.angle_rad = wrap(angle_rad);
        if (is_free(moved)) places.push_back(moved);
      }
    return places;
  }
  void consider_pair(const WheelWeight& one, const WheelWeight& other) {
    if (staying_.empty()) {
      if (!lies_on(one, other, stock_)) consider(std::array{one, other});
      return;
    }
    for (const WheelWeight& first : beside_staying(one))
      for (const WheelWeight& second : beside_staying(other))
        if (!lies_on(first, second, stock_)) consider(std::array{first, second});
  }

  void one() {
    for (const double radius_m : stock_.radius_m)
      if (const WheelWeight weight = nearest(wanted_, radius_m); weight.mass_g > 0.0)
        for (const WheelWeight& place : beside_staying(weight)) consider(std::array{place});
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
        if (const double lacking = apart_rad(first, second, stock_) - (ahead + behind); lacking > 0.0) {
          ahead += 0.5 * lacking;
          behind += 0.5 * lacking;
        }
        first.angle_rad = wrap(std::arg(wanted_) + ahead);
        second.angle_rad = wrap(std::arg(wanted_) - behind);
        consider_pair(first, second);
      });
    });
  }

  void two_on_raster() {
    const int places = static_cast<int>(std::lround(kTurn / stock_.raster_rad));
    each_mass([&](WheelWeight first) {
      for (int k = 0; k < places; ++k) {
        first.angle_rad = wrap(k * stock_.raster_rad);
        if (!is_free(first)) continue;
        for (const double radius_m : stock_.radius_m) {
          const WheelWeight second = nearest(wanted_ - first.moment_g_m(), radius_m);
          if (second.mass_g > 0.0) consider_pair(first, second);
        }
      }
    });
  }

  const WeightStock& stock_;
  Complex wanted_;
  const std::vector<WheelWeight>& staying_;
  std::vector<WheelWeight> best_;
  double least_cost_ = std::numeric_limits<double>::infinity();
};

bool at_one_place(const WheelWeight& a, const WheelWeight& b) {
  return a.radius_m == b.radius_m &&
         std::abs(std::remainder(a.angle_rad - b.angle_rad, kTurn)) <= kSamePlace_rad;
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
  const std::vector<WheelWeight> more = Chooser(stock, -unbalance_g_m, fitted).best();
  for (const WheelWeight& weight : more) added.push_back({WeightAction::kAdd, weight, weight});
  const auto cost = [&](const WeightPlan& plan) {
    const auto touches = std::ranges::count_if(
        plan.step, [](const WeightStep& step) { return step.action != WeightAction::kKeep; });
    return std::abs(plan.residual_g_m(unbalance_g_m)) +
           kTouch * stock.step_g * stock.radius_m.front() * static_cast<double>(touches);
  };
  const WeightPlan adding = plan_of(std::move(added));
  if (fitted.empty()) return adding;
  const std::vector<WheelWeight> all = Chooser(stock, on_wheel - unbalance_g_m, {}).best();
  const WeightPlan anew = plan_of(steps_between(fitted, all, stock));
  return cost(anew) < cost(adding) ? anew : adding;
}

std::string to_string(const WeightStep& step, int radii) {
  const auto text = [](const char* pattern, auto... values) {
    char buffer[96];
    std::snprintf(buffer, sizeof buffer, pattern, values...);
    return std::string(buffer);
  };
  const auto place = [&](const WheelWeight& weight) {
    const long degrees = std::lround(wrap(weight.angle_rad) * 180.0 / std::numbers::pi) % 360;
    return text("%ld°", degrees) + (radii > 1 ? text(" on %.0f mm", 1e3 * weight.radius_m) : "");
  };
  const std::string mass = text("%g g", step.weight.mass_g);
  switch (step.action) {
    case WeightAction::kKeep:
      return "keep " + mass + " at " + place(step.weight);
    case WeightAction::kMove:
      return "move " + mass + " from " + place(step.from) + " to " + place(step.weight);
    case WeightAction::kRemove:
      return "remove " + mass + " at " + place(step.weight);
    case WeightAction::kAdd:
      return "add " + mass + " at " + place(step.weight);
  }
  return "";
}

}  // namespace roadbalance
