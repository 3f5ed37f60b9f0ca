#include "common/config/parse_balancing.hpp"

#include <cmath>
#include <numbers>
#include <set>
#include <string>

namespace roadbalance {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
constexpr Range kRadius_m{0.02, 2};
constexpr double kMostSteps = 100.0;  ///< of mass: plans try them all
constexpr int kMostChoices = 200;     ///< radii times masses: plans try all pairs, every second of a drive

WheelWeight parse_weight(Section section, const WheelConfig& wheel) {
  WheelWeight weight;
  weight.mass_g = section.number("mass_g", {0.1, 1000});
  weight.angle_rad = kRadiansPerDegree * section.number("angle_deg", {-360, 360});
  weight.radius_m = section.number_or("radius_m", kRadius_m, wheel.weight_radius_m);
  if (weight.radius_m >= wheel.rolling_radius_m)
    section.fail("radius_m", "must be less than rolling_radius_m");
  section.finish();
  return weight;
}

}  // namespace

WeightStock parse_stock(Section& root) {
  WeightStock stock;
  auto weights = root.section_if("weights");
  if (!weights) return stock;
  stock.step_g = weights->number_or("step_g", {0.1, 100}, stock.step_g);
  stock.heaviest_g = weights->number_or("heaviest_g", {0.1, 1000}, stock.heaviest_g);
  if (stock.heaviest_g < stock.step_g || stock.heaviest_g > kMostSteps * stock.step_g)
    weights->fail("heaviest_g", "allowed: step_g .. 100 times step_g");
  stock.most = static_cast<int>(weights->integer_or("most", 1, 2, stock.most));
  const double raster_deg = weights->number_or("raster_deg", {0, 180}, 0.0);
  if (raster_deg > 0.0 &&
      (raster_deg < 1.0 || std::abs(std::remainder(360.0, raster_deg)) > 5e-7 * raster_deg))
    weights->fail("raster_deg", "allowed: 0, or a part of 360 that is at least 1");
  stock.raster_rad = raster_deg * kRadiansPerDegree;
  stock.length_m_per_g = 1e-3 * weights->number_or("length_mm_per_g", {0, 10}, 1e3 * stock.length_m_per_g);
  weights->finish();
  return stock;
}

void parse_places(Section& section, const WeightStock& stock, WheelConfig& wheel) {
  wheel.stock = stock;
  wheel.stock.radius_m = {wheel.weight_radius_m};
  if (section.has("weight_radii_m")) wheel.stock.radius_m = section.numbers("weight_radii_m", 0, kRadius_m);
  if (wheel.stock.radius_m.size() > kMostRadii)
    section.fail("weight_radii_m", "has " + std::to_string(wheel.stock.radius_m.size()) +
                                       " radii; allowed: at most " + std::to_string(kMostRadii));
  for (const double radius_m : wheel.stock.radius_m)
    if (radius_m >= wheel.rolling_radius_m)
      section.fail("weight_radii_m", "must be less than rolling_radius_m");
  const double masses = std::floor(stock.heaviest_g / stock.step_g + 1e-9);
  if (const double choices = masses * static_cast<double>(wheel.stock.radius_m.size());
      choices > kMostChoices)
    section.fail("weight_radii_m", "with " + std::to_string(static_cast<int>(masses)) +
                                       " masses on each radius; allowed: at most " +
                                       std::to_string(kMostChoices) + " choices");
  for (Section& weight : section.sections("weight"))
    wheel.fitted.push_back(parse_weight(std::move(weight), wheel));
  if (wheel.fitted.size() > kMostFittedWeights)
    section.fail("weight", std::to_string(wheel.fitted.size()) + " are fitted; allowed: at most " +
                               std::to_string(kMostFittedWeights));
}

BalanceLimits parse_limits(Section& root) {
  BalanceLimits limits;
  auto section = root.section_if("limits");
  if (!section) return limits;
  limits.shop_g = section->number_or("shop_g", {0.1, 1000}, limits.shop_g);
  limits.grade_mm_s = section->number_or("grade_mm_s", {0.1, 4000}, limits.grade_mm_s);
  limits.heaviest_g = section->number_or("heaviest_g", {1, 1000}, limits.heaviest_g);
  limits.force_n = section->number_or("force_n", {1, 10'000}, limits.force_n);
  limits.sigma_g = section->number_or("sigma_g", {0.05, 1000}, limits.sigma_g);
  section->finish();
  return limits;
}

std::vector<SeatConfig> parse_seats(Section& root) {
  std::vector<SeatConfig> seats;
  std::set<std::string> names;
  for (Section& section : root.sections("seat")) {
    SeatConfig seat;
    seat.name = section.text("name");
    if (!names.insert(seat.name).second) section.fail("name", "\"" + seat.name + "\" stands twice");
    const auto place = section.numbers("position_m", 3, {-20, 20});
    seat.position_m = {place[0], place[1], place[2]};
    seat.weight = section.number_or("weight", {1e-3, 1e3}, seat.weight);
    section.finish();
    seats.push_back(seat);
  }
  return seats;
}

}  // namespace roadbalance
