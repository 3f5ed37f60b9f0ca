#include "sim/obstacles.hpp"

#include <cmath>
#include <numbers>

namespace roadbalance::sim {

RoadPoint& RoadPoint::operator+=(const RoadPoint& other) {
  height_m += other.height_m;
  slope += other.slope;
  curvature_1_m += other.curvature_1_m;
  return *this;
}

Obstacles::Obstacles(const ObstacleScenario& scenario, double length_m, double sign,
                     const RandomSequence& random)
    : apart_m_(scenario.per_km > 0.0 ? 1e3 / scenario.per_km : 0.0),
      height_m_(scenario.height_m),
      length_m_(length_m),
      sign_(sign),
      random_(random) {}

RoadPoint Obstacles::at(double place_m) const {
  if (apart_m_ == 0.0) return {};
  const double stretch = std::floor(place_m / apart_m_);
  const auto number = 2 * static_cast<std::int64_t>(stretch);
  const double begin_m = random_.uniform(number) * (apart_m_ - length_m_);
  const double x = (place_m - stretch * apart_m_ - begin_m) / length_m_;
  if (x <= 0.0 || x >= 1.0) return {};
  const double half_m = 0.5 * sign_ * random_.between(number + 1, height_m_.low, height_m_.high);
  const double rate = 2.0 * std::numbers::pi / length_m_;
  const double turn = 2.0 * std::numbers::pi * x;
  return {half_m * (1.0 - std::cos(turn)), half_m * rate * std::sin(turn),
          half_m * rate * rate * std::cos(turn)};
}

}  // namespace roadbalance::sim
