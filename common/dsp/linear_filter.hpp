#pragma once

#include <Eigen/Core>

namespace roadbalance {

/// A linear filter x' = F x + G u of one signal.
struct ContinuousFilter {
  Eigen::MatrixXd F;  ///< [order x order], 1/s
  Eigen::VectorXd G;  ///< [order], 1/s
};

/// The same filter between samples: x[k+1] = A x[k] + b0 u[k] + b1 u[k+1].
struct DiscreteFilter {
  Eigen::MatrixXd A;
  Eigen::VectorXd b0;
  Eigen::VectorXd b1;
};

/// Butterworth low-pass in scaled companion form: state k is (s/wc)^k / D(s/wc) * u, so state 0 is the
/// low-pass output with gain 1 at rest and state k its k-th derivative divided by wc^k.
///
/// @param order      1 .. 12
/// @param cutoff_hz  -3 dB frequency, > 0
/// @throws std::invalid_argument
ContinuousFilter butterworth(int order, double cutoff_hz);

/// Companion form of 1 / prod(poles): state k is s^k / D(s) * u, D given by its coefficients
/// d[0] + d[1] s + ... + d[n-1] s^(n-1) + s^n.
ContinuousFilter companion(const Eigen::VectorXd& denominator);

/// Exact for inputs that are linear between samples (ramp-invariant, first-order hold):
/// with E = exp([F G 0; 0 0 1; 0 0 0] h) in blocks, b1 = E13 / h and b0 = E12 - b1.
/// Bilinear and zero-order hold break the relation between the states by 1..5 % at 500 Hz.
///
/// @param step_s  sample distance, > 0
DiscreteFilter discretise_ramp_invariant(const ContinuousFilter& filter, double step_s);

/// The same of many inputs at once: x[k+1] = A x[k] + B0 u[k] + B1 u[k+1] for x' = F x + G u.
struct DiscreteSystem {
  Eigen::MatrixXd A;   ///< [states x states]
  Eigen::MatrixXd B0;  ///< [states x inputs]
  Eigen::MatrixXd B1;
};

/// @param F        [states x states], 1/s
/// @param G        [states x inputs]
/// @param step_s   sample distance, > 0
/// @throws std::invalid_argument
DiscreteSystem discretise_ramp_invariant(const Eigen::MatrixXd& F, const Eigen::MatrixXd& G, double step_s);

}  // namespace roadbalance
