#pragma once

#include <array>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// Generalised coordinates z = [heave, roll, pitch, z_FL, z_FR, z_RL, z_RR] about static equilibrium, z up.
/// A corner of the body at (x, y) moves up by heave + y roll - x pitch (conventions.md).
inline constexpr int kCoordinates = 7;
inline constexpr int kBodyCoordinates = 3;

using Matrix7 = Eigen::Matrix<double, kCoordinates, kCoordinates>;
using Matrix74 = Eigen::Matrix<double, kCoordinates, kWheels>;
using Vector7 = Eigen::Matrix<double, kCoordinates, 1>;

/// Parameters of the 7-degree-of-freedom car, each an entry of one vector.
/// Order: body mass, roll inertia, pitch inertia, wheel mass[4], spring[4], damper[4], stabiliser[2],
/// tyre[4], tyre damper[4].
enum Parameter : int {
  kBodyMass = 0,
  kRollInertia = 1,
  kPitchInertia = 2,
  kWheelMass = 3,
  kSpring = 7,
  kDamper = 11,
  kStabiliser = 15,
  kTyre = 17,
  kTyreDamper = 21,
  kParameters = 25,
};
using ParameterVector = Eigen::Matrix<double, kParameters, 1>;  ///< kg, kg m^2, N/m, N s/m as named

/// M z'' + P z' + Q z = T d + S u + Sd u'                                                      (1)
struct LinearModel {
  Matrix7 M;    ///< mass, kg (kg m^2 for angles)
  Matrix7 P;    ///< damping, N s/m (per rad, N m s/rad for angles)
  Matrix7 Q;    ///< stiffness, N/m (per rad, N m/rad for angles)
  Matrix74 S;   ///< road height under the four wheels to force, N/m: tyre stiffness
  Matrix74 Sd;  ///< its rate of change to force, N s/m: tyre damping
  Matrix74 W;   ///< vertical force on the four wheels to generalised force, 1 (m for angles); T d = W F_z
};

/// Places of the wheels from the body's centre of mass, x forward, y left: what (1) needs beside parameters.
struct Geometry {
  std::array<double, kWheels> x_m;
  std::array<double, kWheels> y_m;
};

Geometry geometry_of(const ModelConfig& model);

/// Parameters as vehicle.toml states them.
ParameterVector nominal_parameters(const VehicleConfig& vehicle);

/// As derived, when the program was built, from common/multibody/descriptions/seven_dof.toml.
///
/// Every matrix is linear in every parameter: the matrices of a parameter are those of its unit vector,
/// the others zero.  Strut stretch D_i = corner_i - z_i is row i of B; by hand the equations are
///   M = diag(masses), P = B' diag(ds) B + diag(0,0,0,dt),
///   Q = B' diag(cs) B + sum st (B_L - B_R)'(B_L - B_R) + diag(0,0,0,ct).
LinearModel linear_model(const Geometry& geometry, const ParameterVector& parameters);

}  // namespace roadbalance
