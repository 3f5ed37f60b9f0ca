#pragma once

#include <optional>

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"
#include "sim/damper.hpp"

namespace roadbalance::sim {

/// Forces on the four wheels, up, and their rate of change.
struct WheelForces {
  Vector4 force_n = Vector4::Zero();
  Vector4 rate_n_s = Vector4::Zero();
};

/// M z'' + P z' + Q z = W f, solved by the matrix exponential: exact for forces that are cubic in time over
/// a step, given by value and derivative at both its ends.  For a sinusoid of w the relative error of the
/// force is (w h)^4 / 720: 1e-9 at 18 Hz with h = 0.25 ms.
///
/// The part of dampers beyond linear ones is a further force on the right, linear in time over a step; that
/// at the step's end is found by putting in the motion that it makes, twice.  Relative error (w h)^2 / 12 of
/// that force: 7e-5 at 18 Hz.
///
/// Source: S. M. Cox, P. C. Matthews, Exponential time differencing for stiff systems, J. Comput. Phys. 176
/// (2002) 430-455, second order.
class VehicleDynamics {
 public:
  VehicleDynamics(const LinearModel& model, double step_s);
  /// @param dampers  of the same car
  VehicleDynamics(const LinearModel& model, const Dampers& dampers, double step_s);

  /// At rest, under these forces.
  void reset(const WheelForces& forces);

  /// In the motion of another car, under the forces on it.
  void go_on_from(const VehicleDynamics& other);

  /// Advances one step to where `forces` act.
  void step(const WheelForces& forces);

  /// z'' under the forces of the last step (or reset).
  const Vector7& acceleration() const { return acceleration_; }

 private:
  static constexpr int kStates = 2 * kCoordinates;
  using Hold = Eigen::Matrix<double, 4 * kWheels, 1>;  ///< [f0, h f0', f1, h f1']

  void advance_with_dampers();
  void accelerate(const WheelForces& forces);

  double step_s_;
  Eigen::Matrix<double, kStates, kStates> transition_;
  Eigen::Matrix<double, kStates, 4 * kWheels> input_;
  Eigen::Matrix<double, kCoordinates, kStates> from_state_;
  Eigen::Matrix<double, kCoordinates, kWheels> from_force_;
  Eigen::Matrix<double, kStates, 1> state_;  ///< [z, z']
  Hold hold_;
  Vector7 acceleration_;

  std::optional<Dampers> dampers_;  ///< nothing: linear ones
  /// The map of the struts' forces at begin and end of a step to state, and to z''.
  Eigen::Matrix<double, kStates, kWheels> from_begin_, from_end_;
  Matrix74 from_strut_;
  Vector4 strut_n_;  ///< at the step's end
};

}  // namespace roadbalance::sim
