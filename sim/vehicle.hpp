#pragma once

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"

namespace roadbalance::sim {

using Vector4 = Eigen::Matrix<double, kWheels, 1>;

/// Forces on the four wheels, up, and their rate of change.
struct WheelForces {
  Vector4 force_n = Vector4::Zero();
  Vector4 rate_n_s = Vector4::Zero();
};

/// M z'' + P z' + Q z = W f, solved by the matrix exponential: exact for forces that are cubic in time over
/// a step, given by value and derivative at both its ends.  For a sinusoid of w the relative error of the
/// force is (w h)^4 / 720: 1e-9 at 18 Hz with h = 0.25 ms.
class VehicleDynamics {
 public:
  VehicleDynamics(const LinearModel& model, double step_s);

  /// At rest, under these forces.
  void reset(const WheelForces& forces);

  /// Advances one step to where `forces` act.
  void step(const WheelForces& forces);

  /// z'' under the forces of the last step (or reset).
  const Vector7& acceleration() const { return acceleration_; }

 private:
  static constexpr int kStates = 2 * kCoordinates;
  using Hold = Eigen::Matrix<double, 4 * kWheels, 1>;  ///< [f0, h f0', f1, h f1']

  void accelerate(const WheelForces& forces);

  double step_s_;
  Eigen::Matrix<double, kStates, kStates> transition_;
  Eigen::Matrix<double, kStates, 4 * kWheels> input_;
  Eigen::Matrix<double, kCoordinates, kStates> from_state_;
  Eigen::Matrix<double, kCoordinates, kWheels> from_force_;
  Eigen::Matrix<double, kStates, 1> state_;  ///< [z, z']
  Hold hold_;
  Vector7 acceleration_;
};

}  // namespace roadbalance::sim
