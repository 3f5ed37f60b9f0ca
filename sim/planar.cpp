#include "sim/planar.hpp"

#include <numbers>

#include "common/dsp/linear_filter.hpp"

namespace roadbalance::sim {

PlanarMotion::Resonator::Resonator(double frequency_hz, double damping, double step_s) {
  const double w = 2.0 * std::numbers::pi * frequency_hz;
  stiffness_1_s2 = w * w;
  damping_1_s = 2.0 * damping * w;
  const DiscreteFilter d =
      discretise_ramp_invariant(companion(Eigen::Vector2d(stiffness_1_s2, damping_1_s)), step_s);
  transition = {d.A(0, 0), d.A(0, 1), d.A(1, 0), d.A(1, 1)};
  before = {d.b0(0), d.b0(1)};
  now = {d.b1(0), d.b1(1)};
}

void PlanarMotion::Resonator::step(const Array4& force) {
  const Array4 moved =
      transition[0] * displacement + transition[1] * velocity + before[0] * last + now[0] * force;
  velocity =
      (transition[2] * displacement + transition[3] * velocity + before[1] * last + now[1] * force).eval();
  displacement = moved;
  last = force;
  acceleration = force - damping_1_s * velocity - stiffness_1_s2 * displacement;
}

PlanarMotion::PlanarMotion(const ParameterVector& parameters, double forward_hz, double step_s)
    : mass_kg_(parameters.segment<kWheels>(kWheelMass).array()),
      direction_{Resonator(forward_hz, 0.15, step_s), Resonator(15.0, 0.20, step_s)} {}

void PlanarMotion::step(const Array4& forward_n, const Array4& left_n) {
  direction_[0].step(forward_n / mass_kg_);
  direction_[1].step(left_n / mass_kg_);
}

}  // namespace roadbalance::sim
