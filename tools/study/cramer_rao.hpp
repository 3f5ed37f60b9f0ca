#pragma once

#include <array>
#include <bitset>
#include <complex>
#include <vector>

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/estimate.hpp"

namespace roadbalance {

/// Second-order statistics of the roads under the four wheels at one place of the car: heights have the
/// two-sided density
///
///     S_u(om) = q^2 / om^2 w2^2 / (om^2 + w2^2),  q^2 = 2 pi^2 n0^2 Gd(n0) V,  w2 = 2 pi 4 V,  n0 = 0.1 1/m
///
/// times, for exponents e other than 2, (om / (2 pi V n0))^(2 - e); the left and right wheels of an axle are
/// correlated by r at once, a rear wheel follows its front wheel by wheelbase / V with the squared coherence
/// c^2; what a rear wheel's road has of its own is correlated left and right by `rear_own_correlation`.
struct RoadStatistics {
  double roughness_m3 = 16e-6;
  double left_right_correlation = 0.3;
  double rear_coherence2 = 0.95;
  double rear_own_correlation = 0.3;
  double exponent = 2.0;

  /// @returns [kWheels x kWheels] coherences, of every two roads at the circular frequency om
  Eigen::Matrix4cd coherence(const Geometry& geometry, double om, double speed_m_s) const;
  /// @param om  circular frequency, rad/s, > 0
  /// @returns S_u(om) of one wheel's road, m^2/Hz: two-sided, E[u^2] is its integral over f = om / (2 pi)
  double density(double om, double speed_m_s) const;
};

/// A drive whose accelerations of the four wheels are known without noise.
struct BoundQuestion {
  Geometry geometry;
  ParameterVector parameters;
  std::array<std::complex<double>, kWheels> unbalance_kg_m{};
  std::array<double, kWheels> rolling_radius_m{0.3, 0.3, 0.3, 0.3};
  std::vector<double> speeds_m_s{};
  double seconds = 40.0;  ///< at each speed
  RoadStatistics road{};
  std::bitset<kUnknowns> asked{};  ///< the rest is known

  bool random_part = true;     ///< the information in the road's shape of spectrum, too
  bool level_free = true;      ///< one level of the road for each speed is unknown
  bool exponent_free = false;  ///< the road's exponent is unknown, common to all speeds
  /// Band of the random part.  Without noise a wider band has more information, without end.
  double low_hz = 0.0, high_hz = 60.0;
};

/// Least covariance that an unbiased estimator of what is asked can have (Cramer and Rao), from the wheels'
/// accelerations Z with the two-sided spectral matrix S(om) = G S_u G^H, G(om) from road heights to
/// accelerations, in the Gaussian approximation of a long record (Whittle):
///
///     F_ab = sum over speeds  T / 2 sum over wheels i Re{mu_a^H S(Om_i)^-1 mu_b}
///                           + T integral_0^inf tr(S^-1 S_a S^-1 S_b) df
///
/// with mu the phasors of Z at the order of wheel i; S and the matrices S_a = dS/da of all random parts are
/// taken by central differences of the model.  Nuisances (levels, exponent) are eliminated by the inverse of
/// the whole.  Rows and columns of what is not asked are 0.
///
/// Source: P. Whittle, The analysis of multiple stationary time series, J. R. Stat. Soc. B 15 (1953) 125;
/// S. M. Kay, Fundamentals of Statistical Signal Processing I, 1993, sections 3.9 and 15.7.
/// @throws std::invalid_argument if a parameter cannot be determined (singular information)
UnknownMatrix cramer_rao(const BoundQuestion& question);

/// The bound of one wheel as standard deviations; of what was not asked 0.
struct WheelBound {
  double tyre_percent;      ///< of the tyre's stiffness
  double mass_percent;      ///< of the unbalance along itself; not finite for a balanced wheel
  double angle_deg;         ///< of it across, as an angle; the same
  double re_kg_m, im_kg_m;  ///< of U's parts
};
/// @param covariance  of `question`, as cramer_rao() gives it: SI units, places as in Unknowns
/// @param wheel       0 .. kWheels - 1
WheelBound wheel_bound(const UnknownMatrix& covariance, const BoundQuestion& question, int wheel);

}  // namespace roadbalance
