#pragma once

#include <array>
#include <complex>
#include <span>

#include <Eigen/Core>

#include "host/analysis/identify/car_posterior.hpp"
#include "host/analysis/identify/line_moments.hpp"

namespace roadbalance {

/// One standard deviation, in each component, of the first-order radial force of a tyre: tyres have 0 to 60
/// N.
inline constexpr double kRadialForceSigma_n = 30.0;

/// By which a tyre's stiffness differs from speed to speed of a drive, as a part of it: it warms up by about
/// 5 %, and speeds come one after the other.
inline constexpr double kTyreDriftSigma = 0.015;

/// A wheel's first-order force U Om^2 + R: its unbalance, and what of its tyre does not grow with speed.
/// Covariances are of real and imaginary part.  NaN: it turned without its angle.
struct WheelFirstOrder {
  std::complex<double> unbalance_kg_m, force_n;
  Eigen::Matrix2d unbalance_covariance, force_covariance;
  /// W that leaves the least sum of |(U - W) Om^2 + R|^2 over the time driven: U + R sum Om^2 / sum Om^4.
  std::complex<double> correction_kg_m;
  Eigen::Matrix2d correction_covariance;
  /// Of the correction if car and sensors were known exactly: what more driving makes smaller at once.
  Eigen::Matrix2d heard_covariance;
};

/// The car, its unbalances and its tyres' first-order forces, all that is uncertain together.
struct UnbalancePosterior {
  std::array<WheelFirstOrder, kWheels> wheel;
  Eigen::VectorXd v;           ///< CarPosterior's unknowns of car and sensors, the lines heard as well
  Eigen::MatrixXd covariance;  ///< of them
};

/// With y_s the forces at the lines of the speeds driven, N_s y_s = b_s (LineMoments), and v the car's
/// unknowns, of mode v_0 and covariance C before the lines are heard,
///
///     y_s(v_0) + G_s (v - v_0 + t_s) = U + R / Om_s^2 + n_s,    E[n n^H] = N_s^-1,
///     R ~ N(0, kRadialForceSigma_n^2),
///
/// t_s the tyres' own deviations at that speed (kTyreDriftSigma): linear in all that is unknown, and
/// Gaussian.
///
/// @param lines  each of about one speed; wheels that lack a reference there have no equations in it
UnbalancePosterior unbalance_posterior(const CarPosterior& car, const PosteriorMode& mode,
                                       std::span<const LineMoments> lines);

}  // namespace roadbalance
