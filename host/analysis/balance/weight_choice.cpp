#include "host/analysis/balance/weight_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

#include "common/types/angle_units.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr double kTouch = 0.1;      ///< of a step's moment, or of the standard deviation
constexpr double kElsewhere = 0.5;  ///< of a touch: the place listed first is the one that is wanted
constexpr double kMass = 0.01;      ///< of the moments of the weights
constexpr double kAlike = 1e-9;     ///< g m: a choice must not change by rounding
constexpr double kOnPlace = 1e-6;   ///< of a raster's width

/// Angle between two weights that touch, if they are on one place.
double apart_rad(const WheelWeight& a, const WheelWeight& b, const WeightStock& stock) {
  if (a.place != b.place) return 0.0;
  return 0.5 * (a.mass_g + b.mass_g) * stock.length_m_per_g / a.place.radius_m;
}

/// Best first: what a pair leaves at least, by its moments alone, shows when no other can be better.
class Chooser {
 public:
  Chooser(const WeightStock& stock, Complex wanted_g_m, double deviation_g_m,
          const std::vector<WheelWeight>& staying)
      : stock_(stock),
        wanted_(wanted_g_m),
        size_(std::abs(wanted_g_m)),
        direction_rad_(std::arg(wanted_g_m)),
        deviation_(deviation_g_m),
        staying_(staying) {
    consider({});
    if (size_ == 0.0) return;
    const int masses = static_cast<int>(stock.heaviest_g / stock.step_g + 1e-9);
    for (const WeightPlace& place : stock.place)
      for (int k = 1; k <= masses; ++k) one({k * stock.step_g, 0.0, place});
    if (stock.most == 2) two();
  }
  std::vector<WheelWeight> best() && { return std::move(best_); }

 private:
  /// A mass on a place, for which there is room.
  struct Kind {
    WheelWeight weight;
    double moment_g_m;
    double along_g_m;  ///< most that it can do of what is wanted
    double least_g_m;  ///< least that it leaves
  };
  struct Pair {
    double least_cost;
    const Kind *one, *other;
  };

  /// Cost of a weight, apart from the unbalance it leaves.
  double cost_of(const WheelWeight& weight) const {
    return putting_g_m(weight, stock_, deviation_) + kMass * weight.amount_g_m();
  }

  /// Cost of two weights that leave so much.
  double cost_of_two(double left_g_m, const WheelWeight& one, const WheelWeight& other) const {
    return expected_g_m(left_g_m, deviation_) + cost_of(one) + cost_of(other);
  }

  void consider(std::span<const WheelWeight> weights) {
    Complex sum = 0.0;
    double cost = 0.0;
    for (const WheelWeight& weight : weights) {
      sum += weight.moment_g_m();
      cost += cost_of(weight);
    }
    cost += expected_g_m(wanted_ - sum, deviation_);
    if (cost >= least_cost_ - kAlike) return;
    least_cost_ = cost;
    best_.assign(weights.begin(), weights.end());
  }

  const WheelWeight* in_the_way(const WheelWeight& weight, const WheelWeight* also) const {
    if (also != nullptr && lies_on(weight, *also, stock_)) return also;
    for (const WheelWeight& other : staying_)
      if (lies_on(weight, other, stock_)) return &other;
    return nullptr;
  }

  /// The first place at or beyond the weight's own, to one side, where it lies on none.
  std::optional<WheelWeight> beside(WheelWeight weight, double side, const WheelWeight* also) const {
    // Round the rim each of the others is passed once.
    for (std::size_t passed = 0; passed <= staying_.size() + 1; ++passed) {
      const WheelWeight* const other = in_the_way(weight, also);
      if (other == nullptr) return weight;
      double angle_rad = other->angle_rad + side * apart_rad(weight, *other, stock_);
      if (const double raster = stock_.raster_rad; raster > 0.0)
        angle_rad = side * std::ceil(side * angle_rad / raster - kOnPlace) * raster;
      weight.angle_rad = wrap_turn(angle_rad);
    }
    return std::nullopt;
  }

  /// The place nearest to an angle, or where that is taken the nearest to either side: the farther a weight
  /// is from where it is aimed, the more it leaves.
  template <typename Use>
  void aim(WheelWeight weight, double angle_rad, const WheelWeight* also, Use use) const {
    const double raster = stock_.raster_rad;
    weight.angle_rad = wrap_turn(raster > 0.0 ? std::round(angle_rad / raster) * raster : angle_rad);
    if (in_the_way(weight, also) == nullptr) {
      use(weight);
      return;
    }
    for (const double side : {-1.0, 1.0})
      if (const auto place = beside(weight, side, also)) use(*place);
  }

  void consider_with(const WheelWeight& first, const WheelWeight& kind) {
    aim(kind, std::arg(wanted_ - first.moment_g_m()), &first, [&](const WheelWeight& second) {
      consider(std::array{first, second});
    });
  }

  void one(const WheelWeight& weight) {
    Kind kind{weight, weight.amount_g_m(), -std::numeric_limits<double>::infinity(), 0.0};
    aim(weight, direction_rad_, nullptr, [&](const WheelWeight& place) {
      consider(std::array{place});
      const double along = kind.moment_g_m * std::cos(place.angle_rad - direction_rad_);
      if (along <= kind.along_g_m) return;
      kind.along_g_m = along;
      kind.least_g_m = std::abs(wanted_ - place.moment_g_m());
    });
    if (std::isfinite(kind.along_g_m)) kind_.push_back(kind);
  }

  /// The least that two leave: by their moments, by where they have room, and by what one leaves to the
  /// other.
  double least_left_g_m(const Kind& one, const Kind& other) const {
    const double a = one.moment_g_m, b = other.moment_g_m;
    return std::max({0.0, std::abs(a - b) - size_, size_ - (one.along_g_m + other.along_g_m),
                     one.least_g_m - b, other.least_g_m - a});
  }

  void two() {
    std::vector<Pair> pairs;
    for (auto one = kind_.begin(); one != kind_.end(); ++one)
      for (auto other = kind_.begin(); other <= one; ++other) {
        const double cost = cost_of_two(least_left_g_m(*one, *other), one->weight, other->weight);
        if (cost < least_cost_) pairs.push_back({cost, &*one, &*other});
      }
    const auto later = [](const Pair& a, const Pair& b) { return a.least_cost > b.least_cost; };
    std::ranges::make_heap(pairs, later);
    while (!pairs.empty() && pairs.front().least_cost < least_cost_ - kAlike) {
      const auto [cost, one, other] = pairs.front();
      std::ranges::pop_heap(pairs, later);
      pairs.pop_back();
      if (stock_.raster_rad > 0.0)
        on_raster(one->weight, other->weight);
      else
        anywhere(one->weight, other->weight);
    }
  }

  /// Angle at the wanted moment of the triangle, 0 or pi where none closes.
  double corner(double own, double other) const {
    return std::acos(
        std::clamp((size_ * size_ + own * own - other * other) / (2.0 * size_ * own), -1.0, 1.0));
  }

  void anywhere(WheelWeight one, WheelWeight other) {
    double ahead = corner(one.amount_g_m(), other.amount_g_m()),
           behind = corner(other.amount_g_m(), one.amount_g_m());
    if (const double lacking = apart_rad(one, other, stock_) - (ahead + behind); lacking > 0.0) {
      ahead += 0.5 * lacking;
      behind += 0.5 * lacking;
    }
    for (const double side : {1.0, -1.0}) {
      one.angle_rad = wrap_turn(direction_rad_ + side * ahead);
      other.angle_rad = wrap_turn(direction_rad_ - side * behind);
      if (in_the_way(one, nullptr) == nullptr && in_the_way(other, &one) == nullptr) {
        consider(std::array{one, other});
        continue;
      }
      aim(one, one.angle_rad, nullptr, [&](const WheelWeight& first) { consider_with(first, other); });
      aim(other, other.angle_rad, nullptr, [&](const WheelWeight& first) { consider_with(first, one); });
    }
  }

  /// With `one` at an angle theta off the wanted moment the other leaves at least ||x - a e^i theta| - b|.
  /// |x - a e^i theta| grows with |theta|, so that bound grows both ways from the exact angle, and behind the
  /// first place where it is too much there is no better one.
  void on_raster(WheelWeight one, const WheelWeight& other) {
    const double raster = stock_.raster_rad;
    const double own = one.amount_g_m();
    const double exact = corner(own, other.amount_g_m());
    for (const double mirror : {1.0, -1.0}) {
      const double from = direction_rad_ + mirror * exact;
      for (const double side : {1.0, -1.0}) {
        const double reach = (side == mirror ? std::numbers::pi - exact : exact) + kOnPlace * raster;
        double place = std::ceil(from / raster) - (side < 0.0 ? 1.0 : 0.0);
        for (; std::abs(place * raster - from) <= reach; place += side) {
          one.angle_rad = wrap_turn(place * raster);
          const double wanted =
              std::sqrt(std::max(0.0, size_ * size_ + own * own -
                                          2.0 * size_ * own * std::cos(place * raster - direction_rad_)));
          const double left = std::abs(wanted - other.amount_g_m());
          if (cost_of_two(left, one, other) >= least_cost_ - kAlike) break;
          if (in_the_way(one, nullptr) == nullptr) consider_with(one, other);
        }
      }
    }
  }

  const WeightStock& stock_;
  const Complex wanted_;
  const double size_, direction_rad_;
  const double deviation_;
  const std::vector<WheelWeight>& staying_;
  std::vector<Kind> kind_;
  std::vector<WheelWeight> best_;
  double least_cost_ = std::numeric_limits<double>::infinity();
};

}  // namespace

double expected_g_m(Complex residual_g_m, double deviation_g_m) {
  return std::hypot(std::abs(residual_g_m), deviation_g_m);
}

double touch_g_m(const WeightStock& stock, double deviation_g_m) {
  return kTouch * std::max(stock.step_g * stock.place.front().radius_m, deviation_g_m);
}

double putting_g_m(const WheelWeight& weight, const WeightStock& stock, double deviation_g_m) {
  return (weight.place == stock.place.front() ? 1.0 : 1.0 + kElsewhere) * touch_g_m(stock, deviation_g_m);
}

std::vector<WheelWeight> choose_weights(const WeightStock& stock, Complex wanted_g_m, double deviation_g_m,
                                        const std::vector<WheelWeight>& staying) {
  return Chooser(stock, wanted_g_m, deviation_g_m, staying).best();
}

bool lies_on(const WheelWeight& a, const WheelWeight& b, const WeightStock& stock) {
  if (a.place != b.place) return false;
  return std::abs(std::remainder(a.angle_rad - b.angle_rad, kTurn)) < apart_rad(a, b, stock) - 1e-9;
}

double wrap_turn(double angle_rad) {
  const double positive = std::fmod(std::fmod(angle_rad, kTurn) + kTurn, kTurn);
  return positive < kTurn ? positive : 0.0;
}

}  // namespace roadbalance
