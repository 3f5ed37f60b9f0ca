#include "host/analysis/identify/moments.hpp"

namespace roadbalance {

HarmonicMoments& HarmonicMoments::operator+=(const HarmonicMoments& other) {
  normal += other.normal;
  for (std::size_t i = 0; i < right.size(); ++i)
    for (std::size_t j = 0; j < right.size(); ++j) right[i][j] += other.right[i][j];
  return *this;
}

DriveMoments& DriveMoments::operator+=(const DriveMoments& other) {
  seconds += other.seconds;
  speed_seconds += other.speed_seconds;
  sections += other.sections;
  for (std::size_t i = 0; i < chassis.size(); ++i) {
    chassis[i] += other.chassis[i];
    chassis_power[i] += other.chassis_power[i];
  }
  for (std::size_t i = 0; i < wheel.size(); ++i) {
    wheel[i].tyre += other.wheel[i].tyre;
    wheel[i].tyre_unbalance += other.wheel[i].tyre_unbalance;
  }
  harmonic += other.harmonic;
  body.normal += other.body.normal;
  body.right += other.body.right;
  return *this;
}

void DriveMoments::weigh_road(double factor) {
  for (auto& instrument : chassis) instrument *= factor;
  for (double& power : chassis_power) power *= factor;
  for (Wheel& each : wheel) {
    each.tyre *= factor;
    each.tyre_unbalance *= factor;
  }
}

}  // namespace roadbalance
