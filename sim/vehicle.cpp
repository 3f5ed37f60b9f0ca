#include "sim/vehicle.hpp"

#include <Eigen/LU>
#include <unsupported/Eigen/MatrixFunctions>

namespace roadbalance::sim {

VehicleDynamics::VehicleDynamics(const LinearModel& model, double step_s) : step_s_(step_s) {
  const Matrix7 inverse_mass = model.M.inverse();
  from_state_ << -inverse_mass * model.Q, -inverse_mass * model.P;
  from_force_ = inverse_mass * model.W;

  // In units of the step the force is g0 + g1 t + g2 t^2/2 + g3 t^3/6; its derivatives are further states of
  // an augmented system, whose exponential holds the transition and the effect of every g.
  constexpr int kAll = kStates + 4 * kWheels;
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(kAll, kAll);
  block.block(0, kCoordinates, kCoordinates, kCoordinates).setIdentity();
  block.block(kCoordinates, 0, kCoordinates, kStates) = from_state_;
  block.block(kCoordinates, kStates, kCoordinates, kWheels) = from_force_;
  block.topRows(kStates) *= step_s;
  block.block(kStates, kStates + kWheels, 3 * kWheels, 3 * kWheels).setIdentity();
  const Eigen::MatrixXd e = block.exp();
  transition_ = e.topLeftCorner(kStates, kStates);

  // Cubic Hermite: f0, f0', f1, f1' -> g0, g1, g2, g3 (derivatives at the step's begin).
  Eigen::Matrix4d hermite;
  hermite << 1, 0, 0, 0,  //
      0, 1, 0, 0,         //
      -6, -4, 6, -2,      //
      12, 6, -12, 6;
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(4 * kWheels, 4 * kWheels);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      spread.block(kWheels * i, kWheels * j, kWheels, kWheels).diagonal().setConstant(hermite(i, j));
  input_ = e.topRightCorner(kStates, 4 * kWheels) * spread;
  reset({});
}

VehicleDynamics::VehicleDynamics(const LinearModel& model, const Dampers& dampers, double step_s)
    : VehicleDynamics(model, step_s) {
  if (dampers.are_linear()) return;
  dampers_ = dampers;
  from_strut_ = model.M.inverse() * dampers.direction();
  // Force f0 + (f1 - f0) t, t in steps, as two further states.
  constexpr int kAll = kStates + 2 * kWheels;
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(kAll, kAll);
  block.block(0, kCoordinates, kCoordinates, kCoordinates).setIdentity();
  block.block(kCoordinates, 0, kCoordinates, kStates) = from_state_;
  block.block(kCoordinates, kStates, kCoordinates, kWheels) = from_strut_;
  block.topRows(kStates) *= step_s;
  block.block(kStates, kStates + kWheels, kWheels, kWheels).setIdentity();
  const Eigen::MatrixXd e = block.exp();
  from_end_ = e.block(0, kStates + kWheels, kStates, kWheels);
  from_begin_ = e.block(0, kStates, kStates, kWheels) - from_end_;
}

void VehicleDynamics::reset(const WheelForces& forces) {
  state_.setZero();
  strut_n_.setZero();
  hold_.tail<2 * kWheels>() << forces.force_n, step_s_ * forces.rate_n_s;
  accelerate(forces);
}

void VehicleDynamics::go_on_from(const VehicleDynamics& other) {
  state_ = other.state_;
  hold_ = other.hold_;
  strut_n_ = other.strut_n_;
  acceleration_ = other.acceleration_;
}

void VehicleDynamics::step(const WheelForces& forces) {
  hold_.head<2 * kWheels>() = hold_.tail<2 * kWheels>().eval();
  hold_.tail<2 * kWheels>() << forces.force_n, step_s_ * forces.rate_n_s;
  state_ = (transition_ * state_ + input_ * hold_).eval();
  if (dampers_) advance_with_dampers();
  accelerate(forces);
}

/// Adds to the linear step what the dampers' further forces make of it.
void VehicleDynamics::advance_with_dampers() {
  constexpr int kTimes = 2;
  state_.noalias() += from_begin_ * strut_n_;
  Eigen::Matrix<double, kStates, 1> end = state_ + from_end_ * strut_n_;
  for (int k = 0; k < kTimes; ++k) {
    strut_n_ = dampers_->excess_n(end.tail<kCoordinates>());
    end = state_ + from_end_ * strut_n_;
  }
  state_ = end;
}

void VehicleDynamics::accelerate(const WheelForces& forces) {
  acceleration_.noalias() = from_state_ * state_;
  acceleration_.noalias() += from_force_ * forces.force_n;
  if (dampers_) acceleration_.noalias() += from_strut_ * strut_n_;
}

}  // namespace roadbalance::sim
