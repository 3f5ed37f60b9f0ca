#pragma once

#include <complex>
#include <map>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/linear_filter.hpp"
#include "common/vehicle/contact_patch.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/moments.hpp"
#include "host/analysis/identify/signals.hpp"

namespace roadbalance {

/// A car at constant speed on four independent roads, with the filter that makes the instruments, as one
/// linear system: state x = [z, z', (shaping state, u) of each wheel, 5 filter states of each coordinate].
/// Gives exact covariances, computed by nothing that the product uses for estimation.
class ExactDrive {
 public:
  /// Lower corner of the roads, in waves a metre: u = 1/(s + w1) w2/(s + w2) w, w1 = 2 pi V times this, w2
  /// the contact patch's; below it a road is flat in its spectrum.
  static constexpr double kLeastWave_1_m = 0.01;

  ExactDrive(const Geometry& geometry, const ParameterVector& parameters,
             const std::array<std::complex<double>, kWheels>& unbalance_kg_m, double speed_m_s,
             double rolling_radius_m, double road_gd_m3, const ContinuousFilter& filter, double corner_hz);

  /// Exact averages of relation (2) for instrument j (states j, j+1, j+2) of one coordinate's acceleration,
  /// or of the cosine or sine of a wheel's angle: rows as in signals.hpp.
  InstrumentMoments<double> moments(int signal, int j, double lag_s) const;
  /// E[W'' u'] and E[W'' F'] of the same instrument: road heights and unbalance forces of the four wheels.
  Eigen::RowVector4d with_road(int signal, int j, double lag_s) const;
  Eigen::RowVector4d with_unbalance_force(int signal, int j, double lag_s) const;
  /// E[W''(t) Om^2 e^{j alpha_i(t + lag)}]: what DriveMoments calls tyre_unbalance.
  std::complex<double> with_reference(int signal, int j, double lag_s, int wheel) const;
  double power(int signal, int j) const;

  double omega(int wheel) const { return omega_[static_cast<std::size_t>(wheel)]; }
  /// Phasors of z'' at the order of one wheel.
  Eigen::VectorXcd acceleration_phasor(int wheel) const { return phasor_.col(wheel); }

 private:
  struct Row {  ///< one scalar: its row in the state, and its phasor at each wheel's order
    Eigen::RowVectorXd state;
    Eigen::RowVectorXcd phasor;
  };
  Row filter_state(int signal, int k) const;
  double covariance(const Row& past, const Eigen::RowVectorXd& future_state,
                    const Eigen::RowVectorXcd& future_phasor, double lag_s) const;

  /// E[x(t) x(t + lag)'] of the scaled state.
  const Eigen::MatrixXd& at_lag(double lag_s) const;

  double corner_rad_s_;
  Eigen::Index order_;
  std::array<double, kWheels> omega_{};
  std::array<std::complex<double>, kWheels> force_{};
  Eigen::MatrixXd A_, X_;  ///< of the scaled state
  Eigen::VectorXd scale_;
  mutable std::map<double, Eigen::MatrixXd> at_lag_;  ///< exponentials are dear
  Eigen::MatrixXd acceleration_rows_;
  Eigen::MatrixXcd phasor_;                        ///< [coordinate x wheel order] of z''
  std::vector<Eigen::VectorXcd> filter_response_;  ///< per wheel order: filter states per unit input
};

}  // namespace roadbalance
