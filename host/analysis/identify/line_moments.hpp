#pragma once

#include <array>
#include <map>

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
  double seconds = 0.0;
  Eigen::Vector4d turned_rad = Eigen::Vector4d::Zero();

  LineMoments& operator+=(const LineMoments& other);
  /// b of all wheels.
  Eigen::Vector4cd right_sides(const Eigen::MatrixXd& wheel_forces) const;
  /// Mean rotation rates, rad/s.
  Eigen::Vector4d omega() const { return turned_rad / seconds; }
};

/// A section at its wheels' lines, by channels, and the density of the road beside them.
struct LineReading {
  HarmonicReading reading;
  double seconds = 0.0;  ///< that it counts for

  /// RoadSpectrum for one second of even window: what stretches of any length and window share.
  RoadSpectrum density() const;
};

/// Reads sections of steady speed.
class HarmonicReader {
 public:
  HarmonicReader(const Geometry& geometry, double rate_hz) : geometry_(geometry), rate_hz_(rate_hz) {}

  /// @param signals    [kSignals x samples]
  /// @param readings   [channel + further x samples] m/s^2 of the vertical channels, and further signals
  /// @param quiet      [sample] 0 where the section is not to be used
  /// @param omega      rotation rate of each wheel, rad/s; 0: it has no reference here
  /// @param speed_m_s  of the car
  LineReading read(const Eigen::Ref<const SignalMatrix>& signals,
                   const Eigen::Ref<const Eigen::MatrixXd>& readings,
                   const Eigen::Ref<const Eigen::ArrayXd>& quiet, const Eigen::Vector4d& omega,
                   double speed_m_s);

 private:
  const HarmonicInstrument& instrument(Eigen::Index samples);

  Geometry geometry_;
  double rate_hz_;
  std::map<Eigen::Index, HarmonicInstrument> instruments_;  ///< by samples
};

/// @param channels    of the readings; what is behind them is taken as it is
/// @param density     of the road of this section and such as are like it (LineReading::density)
/// @param parameters  present knowledge of the car, for the weights only
LineMoments line_moments(const LineReading& section, Eigen::Index channels, const RoadSpectrum& density,
                         const Geometry& geometry, const ParameterVector& parameters);

}  // namespace roadbalance
