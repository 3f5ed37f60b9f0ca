#pragma once

#include <cstdint>

#include "sim/random.hpp"
#include "sim/scenario.hpp"

namespace roadbalance::sim {

/// Height of a road and its derivatives along it.
struct RoadPoint {
  double height_m = 0.0;
  double slope = 0.0;
  double curvature_1_m = 0.0;

  RoadPoint& operator+=(const RoadPoint& other);
};

/// Raised cosines on a road, one in each stretch of 1 / per_km, somewhere in it.  A pure function of seed,
/// track and place: rear wheels meet what front wheels met.
class Obstacles {
 public:
  /// @param length_m  of each
  /// @param sign      1: upwards, -1: downwards
  Obstacles(const ObstacleScenario& scenario, double length_m, double sign, const RandomSequence& random);

  RoadPoint at(double place_m) const;

 private:
  double apart_m_;  ///< 0: there are none
  Range height_m_;
  double length_m_, sign_;
  RandomSequence random_;
};

}  // namespace roadbalance::sim
