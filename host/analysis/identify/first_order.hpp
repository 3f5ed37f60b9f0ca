#pragma once

#include <array>
#include <bitset>
#include <complex>
#include <span>

#include <Eigen/Core>

#include "host/analysis/identify/moments.hpp"

namespace roadbalance {

/// First-order force on a wheel at one speed: Re{force e^{j alpha}}, all that turns with the wheel together.
struct FirstOrderForce {
  double omega;                  ///< rotation rate, rad/s
  std::complex<double> force_n;  ///< a_s
  double variance_n2;            ///< of each component
};

/// The speeds separate an unbalance from a force if its sigma beside the force is at most so many times that
/// of the unbalance alone.
inline constexpr double kSeparable = 3.0;

/// Parts of first-order forces at several speeds: an unbalance U and a force R that does not grow
/// with speed, a tyre's radial force variation,
///
///     a_s = U Om_s^2 + R + n_s,    k_s = 1 / variance of n_s,
///
///     [ sum k Om^4  sum k Om^2 ] [U]   [ sum k Om^2 a ]
///     [ sum k Om^2  sum k      ] [R] = [ sum k a      ],
///
/// its inverse the covariance of (U, R) in each component.  The equivalent unbalance of the speeds driven has
/// R = 0 and sigma (sum k Om^4)^-1/2.
struct FirstOrderFit {
  double sigma_equivalent_kg_m = 0.0;  ///< of each component, as all here
  bool separable = false;              ///< by the speeds; else the rest is not to be used
  std::complex<double> unbalance_kg_m;
  double sigma_unbalance_kg_m = 0.0;  ///< infinite at a single speed
  std::complex<double> force_n;
  double sigma_force_n = 0.0;
};

/// Speeds of one car and road of which one that is this share of another separates an unbalance from a force,
/// if both are driven for the same time: k grows as V, so with a share of q
///
///     1 - r^2 = 1 - (1 + q^3)^2 / ((1 + q) (1 + q^5)) >= 1 / kSeparable^2,    q <= 0.66.
inline constexpr double kSeparatingShare = 0.65;

/// @param forces  at least one, omega and variance > 0
FirstOrderFit fit_first_order(std::span<const FirstOrderForce> forces);

/// Forces of the wheels that have equations in the moments of about one speed; others have variance 0.
/// @param parameters  the car's, tyres included
/// @param omega       mean rotation rates there
/// @param asked       wheels that may be out of balance
std::array<FirstOrderForce, kWheels> first_order_forces(
    const HarmonicMoments& moments, const Geometry& geometry, const ParameterVector& parameters,
    const Eigen::Vector4d& omega, const std::bitset<kWheels>& asked = std::bitset<kWheels>().set());

}  // namespace roadbalance
