#pragma once

#include <array>
#include <complex>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"

namespace roadbalance {

/// Moments of one instrument: the averages that stand with M, P and Q in the identification relation.
///
/// An instrument is any signal W(t) with two derivatives.  From M z'' + P z' + Q z = T d + S u, multiplied by
/// W''(t) and integrated by parts (a taper makes the end terms zero), for each row of the matrices:
///
///     E[W'' z''] M' - E[W' z''] P' + E[W z''] Q' = E[W'' d'] T' + E[W'' u'] S'                  (2)
///
/// Only measured accelerations occur, and no covariance of positions or speeds.  The Q term's sign is that of
/// two integrations by parts, the P term's that of one.
template <typename Scalar>
struct InstrumentMoments {
  using Row = Eigen::Matrix<Scalar, 1, kCoordinates>;
  Row w2 = Row::Zero();  ///< sum of W''(t) z''(t + lag)', m/s^2 (rad/s^2) times W'''s unit
  Row w1 = Row::Zero();  ///< sum of W'(t)  z''(t + lag)', that times s
  Row w0 = Row::Zero();  ///< sum of W(t)   z''(t + lag)', that times s^2

  InstrumentMoments& operator+=(const InstrumentMoments& other) {
    w2 += other.w2;
    w1 += other.w1;
    w0 += other.w0;
    return *this;
  }

  InstrumentMoments& operator*=(double factor) {
    w2 *= factor;
    w1 *= factor;
    w0 *= factor;
    return *this;
  }

  /// Left side of (2) for one row (degree of freedom) of the matrices.  Linear in the parameters.
  Scalar force(const LinearModel& model, int row) const {
    return (w2 * model.M.row(row).transpose() - w1 * model.P.row(row).transpose() +
            w0 * model.Q.row(row).transpose())
        .value();
  }
};

inline constexpr int kChassisInstrumentsPerSignal = 3;
inline constexpr int kChassisInstruments = kChassisInstrumentsPerSignal * kCoordinates;

/// Normal equations N U = sum_j force of right[.][j] on wheel j's row, for the unbalance phasors U of all
/// wheels (harmonic.hpp).
struct HarmonicMoments {
  Eigen::Matrix4cd normal = Eigen::Matrix4cd::Zero();
  /// [unknown wheel][wheel whose row the force is of]
  std::array<std::array<InstrumentMoments<std::complex<double>>, kWheels>, kWheels> right{};

  HarmonicMoments& operator+=(const HarmonicMoments& other);
};

/// Normal equations N U = right of the unbalance phasors from the body's accelerations alone
/// (body_instrument.hpp).
struct BodyMoments {
  Eigen::Matrix4cd normal = Eigen::Matrix4cd::Zero();
  Eigen::Vector4cd right = Eigen::Vector4cd::Zero();
};

/// All that the estimate needs of a stretch of driving; moments of stretches add.
struct DriveMoments {
  double seconds = 0.0;
  double speed_seconds = 0.0;  ///< integral of the speed, m
  int sections = 0;

  /// It is of one section.
  void count(double section_seconds, double speed_m_s) {
    sections = 1;
    seconds = section_seconds;
    speed_seconds = section_seconds * speed_m_s;
  }

  /// Chassis rows of (2): no road and no unbalance acts on the body.
  std::array<InstrumentMoments<double>, kChassisInstruments> chassis{};
  std::array<double, kChassisInstruments> chassis_power{};  ///< sum of W''^2

  struct Wheel {
    /// The wheel's own past acceleration as instrument: the road of the future does not depend on it.
    InstrumentMoments<double> tyre{};
    std::complex<double> tyre_unbalance =
        0.0;  ///< sum of W''(t) Om^2 r(t + lag): its share of U is Re{U ...}
  };
  std::array<Wheel, kWheels> wheel{};

  /// The angle references as instruments.
  HarmonicMoments harmonic;

  /// In place of all these where no sensor sits on some wheel's carrier.
  BodyMoments body;

  DriveMoments& operator+=(const DriveMoments& other);
  /// Multiplies what grows with the square of what the road shakes, the equations of suspension and tyres:
  /// each is 0 with any factor.
  void weigh_road(double factor);
};

}  // namespace roadbalance
