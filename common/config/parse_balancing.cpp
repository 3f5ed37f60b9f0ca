#include "common/config/parse_balancing.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "common/types/angle_units.hpp"

namespace roadbalance {
namespace {

constexpr Range kRadius_m{0.02, 2};
constexpr double kMostSteps = 100.0;  ///< of mass: plans try them all
constexpr int kMostChoices = 200;     ///< places times masses: plans try all pairs, every second of a drive

double parse_radius(Section& section, const WheelConfig& wheel) {
  const double radius_m = section.number("radius_m", kRadius_m);
  if (radius_m >= wheel.rolling_radius_m) section.fail("radius_m", "must be less than rolling_radius_m");
  return radius_m;
}

WeightKind parse_kind(Section& section) {
  return section.choice("kind", {"clip", "adhesive"}) == 0 ? WeightKind::kClip : WeightKind::kAdhesive;
}

RimPlane parse_rim_plane(Section& section) {
  return section.choice("plane", {"inner", "outer"}) == 0 ? RimPlane::kInner : RimPlane::kOuter;
}

WeightPlace parse_place(Section& section, const WheelConfig& wheel) {
  return {parse_radius(section, wheel), parse_kind(section), parse_rim_plane(section)};
}

/// The first of the wheel's places that has all that is given of this weight's, or else the place given.
WeightPlace place_of_weight(Section& section, const WheelConfig& wheel) {
  std::optional<double> radius_m;
  std::optional<WeightKind> kind;
  std::optional<RimPlane> plane;
  if (section.has("radius_m")) radius_m = parse_radius(section, wheel);
  if (section.has("kind")) kind = parse_kind(section);
  if (section.has("plane")) plane = parse_rim_plane(section);
  for (const WeightPlace& place : wheel.stock.place)
    if (radius_m.value_or(place.radius_m) == place.radius_m && kind.value_or(place.kind) == place.kind &&
        plane.value_or(place.plane) == place.plane)
      return place;
  for (const auto& [key, is_given] : {std::pair{"radius_m", radius_m.has_value()},
                                      {"kind", kind.has_value()},
                                      {"plane", plane.has_value()}})
    if (!is_given)
      section.fail(key,
                   "missing; allowed: to leave it out where a [[wheel.place]] has all else that is told");
  return {*radius_m, *kind, *plane};
}

WheelWeight parse_weight(Section section, const WheelConfig& wheel) {
  WheelWeight weight;
  weight.mass_g = section.number("mass_g", {0.1, 1000});
  weight.angle_rad = kDegree * section.number("angle_deg", {-360, 360});
  weight.place = place_of_weight(section, wheel);
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
  stock.raster_rad = raster_deg * kDegree;
  stock.length_m_per_g = 1e-3 * weights->number_or("length_mm_per_g", {0, 10}, 1e3 * stock.length_m_per_g);
  weights->finish();
  return stock;
}

void parse_places(Section& section, const WeightStock& stock, WheelConfig& wheel) {
  wheel.stock = stock;
  if (section.has("weight_radii_m"))
    section.fail("weight_radii_m",
                 "unknown key; allowed: a [[wheel.place]] with radius_m, kind and plane for each place");
  std::vector<WeightPlace>& places = wheel.stock.place;
  for (Section& place : section.sections("place")) {
    places.push_back(parse_place(place, wheel));
    if (std::ranges::count(places, places.back()) > 1) place.fail("radius_m", "this place stands twice");
    place.finish();
  }
  if (places.size() > kMostPlaces)
    section.fail("place", std::to_string(places.size()) + " are told; allowed: at most " +
                              std::to_string(kMostPlaces));
  if (places.empty()) places.push_back({.radius_m = wheel.weight_radius_m});
  const double masses = std::floor(stock.heaviest_g / stock.step_g + 1e-9);
  if (const double choices = masses * static_cast<double>(places.size()); choices > kMostChoices)
    section.fail("place", "with " + std::to_string(static_cast<int>(masses)) +
                              " masses on each place; allowed: at most " + std::to_string(kMostChoices) +
                              " choices");
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
