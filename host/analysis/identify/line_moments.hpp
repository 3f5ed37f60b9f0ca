#pragma once

#include <array>

#include <Eigen/Core>

#include "host/analysis/identify/harmonic.hpp"

namespace roadbalance {

/// Normal equations of the unbalances, at about one speed, by phasors of the channels as they were measured.
/// Whatever the car and the sensors' gains are taken for, with F its wheel_forces (car_posterior.hpp),
///
///     N U = b,    b_i = sum of F o right[i].
///
/// They add.
struct LineMoments {
  Eigen::Matrix4cd normal = Eigen::Matrix4cd::Zero();
  /// [unknown wheel] of the four wheels' forces by accelerations, velocities and displacements of m channels,
  /// and n further signals [4 x 3 m + n]
  std::array<Eigen::MatrixXcd, kWheels> right;
  double seconds = 0.0;  ///< quiet ones
  Eigen::Vector4d turned_rad = Eigen::Vector4d::Zero();

  LineMoments& operator+=(const LineMoments& other);
  /// b of all wheels.
  Eigen::Vector4cd right_sides(const Eigen::MatrixXd& wheel_forces) const;
  /// Mean rotation rates, rad/s.
  Eigen::Vector4d omega() const { return turned_rad / seconds; }
};

/// @param channels    of the readings; what is behind them is taken as it is
/// @param section     with its readings
/// @param density     of the road of this section and such as are like it (HarmonicReading::density)
/// @param parameters  present knowledge of the car, for the weights only
LineMoments line_moments(const HarmonicReading& section, Eigen::Index channels, const RoadSpectrum& density,
                         const Geometry& geometry, const ParameterVector& parameters);

}  // namespace roadbalance
