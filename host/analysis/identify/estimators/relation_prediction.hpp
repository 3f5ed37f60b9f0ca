#pragma once

#include <array>
#include <complex>
#include <vector>

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/estimators/relation_covariances.hpp"

namespace roadbalance {

/// A car with unbalances, as far as it is known so far.
struct PredictedCar {
  Geometry geometry;
  LinearModel model;
  std::array<std::complex<double>, kWheels> unbalance_kg_m{};
};

/// An instrument w'' of a wheel's equations.
struct RelationInstrument {
  std::size_t lag;  ///< place in RelationCovariances::lag
  int row;          ///< of LaggedCovariances
};

/// The covariances of relation (2) that are to be expected at one speed: from the car's response, the
/// instruments' filter and the spectrum of the roads.
///
/// With G(om) from road heights to accelerations, h_a(om) from the acceleration that it filters to instrument
/// a and S_u(om) the spectral matrix of the roads, E[w''_a(t) F(t + tau)] of the force F = (ct + j om dt) u
/// of a tyre on its wheel is
///
///     integral conj(h_a G_a) S_u' F e^{j om tau} df.                                           (a)
///
/// The roads are as rough, wheel by wheel, and as coherent as the measured covariances tell:
///
///     S_u,ij = b_ij om^-w / (1 + (om / w2)^2) e^{-j om (x_j - x_i) / V},   w2 = 2 pi 4 V,
///
/// b real, symmetric and not negative, by least squares of the measured E[w'' z''] less what is harmonic in
/// it; w, the exponent, is given.  Wheels are taken to turn at rates that differ: of wheels in step the
/// harmonic parts do not add up as here.
///
/// Integrals are sums over evenly spaced ln om: poles of the car lie by asin(damping) off the real axis, so
/// the error falls as exp(-2 pi asin(damping) / step).  Source: L. N. Trefethen, J. A. C. Weideman, The
/// exponentially convergent trapezoidal rule, SIAM Review 56 (2014) 385.
class RelationPrediction {
 public:
  /// @param measured  at this speed; tells how rough and coherent the roads are
  /// @param filter    that the covariances are of
  /// @throws std::invalid_argument as butterworth(), or if `measured` has not the lags of `filter`
  RelationPrediction(const PredictedCar& car, const RelationCovariances& measured,
                     const RelationFilter::Options& filter, double road_exponent);

  /// (a) of the wheel's tyre; 0 for the angles, which do not depend on the road.
  Eigen::VectorXd road(int wheel, const std::vector<RelationInstrument>& instruments) const;

  /// Covariance [instrument x instrument] of the means over the measured time of w''_a(t) F(t + tau_a):
  ///
  ///     T V_ab = integral P_ab P_FF + P_aF P_bF df + sum over wheels Re{conj(A_a) A_b} P_FF(Om_i) / 2,
  ///
  /// P the two-sided spectra of the random parts of instruments (as late as their lags) and force, A the
  /// instruments' phasors at the order of wheel i.
  ///
  /// Source: G. M. Jenkins, D. G. Watts, Spectral Analysis and its Applications, 1968, section 5.3
  /// (Bartlett).
  Eigen::MatrixXd scatter(int wheel, const std::vector<RelationInstrument>& instruments) const;

  /// Harmonic parts [instrument x 3] of the left side of (2), the wheel's row, for a unit of its tyre's
  /// stiffness, of Re U and of Im U.
  Eigen::MatrixXd harmonic(int wheel, const std::vector<RelationInstrument>& instruments) const;

 private:
  struct Frequency {
    double omega;
    double weight;                                                 ///< of the two-sided integral, times S_u
    Eigen::VectorXcd filter;                                       ///< h of w''_j
    Eigen::Matrix<std::complex<double>, kCoordinates, kWheels> G;  ///< accelerations per road height
  };

  Eigen::VectorXcd filter_at(double omega) const;
  double road_shape(double omega) const;  ///< om^-w / (1 + (om / w2)^2)
  /// e^{j om x_i / V}: how much earlier than the car's centre a wheel meets the road.
  Eigen::Vector4cd advance(double omega) const;
  std::complex<double> tyre(int wheel, double omega) const;  ///< force per road height
  void fit_roads(const RelationCovariances& measured);
  /// Phasors of an instrument, as late as its lag, at the orders of all wheels.
  Eigen::RowVector4cd phasors(const RelationInstrument& instrument) const;

  PredictedCar car_;
  RelationFilter::Options options_;
  ContinuousFilter filter_;
  Annihilator H_;
  double exponent_, speed_m_s_, seconds_;
  Eigen::Vector4d omega_;
  std::vector<Frequency> grid_;
  Eigen::Matrix<std::complex<double>, kCoordinates, kWheels> line_;  ///< phasors of z'' at each wheel's order
  Eigen::MatrixXcd line_filter_;  ///< [instrument j x wheel] h at each wheel's order
  Eigen::Matrix4d roads_, root_;  ///< b = root root'
};

}  // namespace roadbalance
