#include "host/analysis/orders/rotor_angle.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "common/types/angle_units.hpp"

namespace roadbalance {
namespace {

constexpr double kLeastReference = 0.5;  // of full scale; a known angle has nearly 1

}  // namespace

std::vector<const NodeConfig*> nodes_of(const VehicleConfig& vehicle, std::span<const Rotor> rotors,
                                        int node) {
  std::vector<const NodeConfig*> nodes{&vehicle.node[static_cast<std::size_t>(node)]};
  for (const Rotor& rotor : rotors)
    for (const int w : rotor.wheel) {
      const NodeConfig* const reads = &vehicle.node_named(vehicle.wheel[static_cast<std::size_t>(w)].node);
      if (std::ranges::find(nodes, reads) == nodes.end()) nodes.push_back(reads);
    }
  return nodes;
}

RotorAngle::RotorAngle(const VehicleConfig& vehicle, const Rotor& rotor,
                       const std::vector<const NodeConfig*>& nodes)
    : ratio_(rotor.ratio) {
  for (const int w : rotor.wheel) {
    const WheelConfig& wheel = vehicle.wheel[static_cast<std::size_t>(w)];
    const auto at = std::ranges::find(nodes, &vehicle.node_named(wheel.node)) - nodes.begin();
    wheel_.push_back({static_cast<std::size_t>(at), wheel.line});
  }
}

RotorAngle::Reading RotorAngle::read(const GridJoin::Row& row) {
  const State known = state(row);
  if (known == State::kNotKnown) return {known, 0.0};
  double sum = 0.0;
  for (Wheel& wheel : wheel_) {
    const GridJoin::Sample& sample = row.sample[wheel.node];
    const auto sine = static_cast<std::size_t>(kAccelerations + 2 * wheel.line);
    const std::complex<double> reference((*sample.counts)[sine + 1], (*sample.counts)[sine]);
    if (std::abs(reference) < kLeastReference * kFullScaleCounts) return {State::kNotKnown, 0.0};
    const double now = std::arg(reference);
    wheel.angle_rad =
        wheel.angle_rad ? *wheel.angle_rad + std::remainder(now - *wheel.angle_rad, kTurn) : now;
    sum += *wheel.angle_rad;
  }
  return {known, ratio_ * sum / static_cast<double>(wheel_.size())};
}

RotorAngle::State RotorAngle::state(const GridJoin::Row& row) const {
  State state = State::kKnown;
  for (const Wheel& wheel : wheel_) {
    const std::int32_t quality = row.sample[wheel.node].quality;
    if ((quality & quality_no_reference(wheel.line)) != 0) return State::kNotKnown;
    if ((quality & (wheel.line == 0 ? kQualityUncertainAngle0 : kQualityUncertainAngle1)) != 0)
      state = State::kUncertain;
  }
  return state;
}

void RotorAngle::forget() {
  for (Wheel& wheel : wheel_) wheel.angle_rad.reset();
}

}  // namespace roadbalance
