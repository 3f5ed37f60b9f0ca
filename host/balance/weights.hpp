#pragma once

#include <array>
#include <numbers>

#include "common/bus/results.hpp"

namespace roadbalance {

/// Balancing weights are sold in steps of this mass.
inline constexpr double kWeightStepG = 5.0;

/// Two equal weights that together do what one of any mass would.  Angles from the zero mark in the direction
/// of rotation, 0 .. 2 pi.
struct WeightPair {
  double weight_g = 0;  ///< mass of each, a multiple of kWeightStepG
  std::array<double, 2> angle_rad{};
};

/// The counterweight of a wheel: opposite to the heavy spot, at the weight radius.
struct Counterweight {
  double mass_g = 0;
  double angle_rad = 0;  ///< 0 .. 2 pi
  WeightPair pair;       ///< the same by stock weights, exact in mass and angle
};

/// @param mass_g  > 0
/// Two weights m = k step, k = ceil(mass / (2 step)), at angle +- acos(mass / (2 m)); IDENTIFICATION
/// section 10.
WeightPair stock_weights(double mass_g, double angle_rad);

Counterweight counterweight(double unbalance_g, double heavy_spot_rad);

/// True if the unbalance could as well be none: it lies inside its own 95 % ellipse.  Then a weight is as
/// likely to do harm as good.
/// @param unbalance_g  (cos, sin) components; @param covariance_g2 of them
bool within_own_uncertainty(const Eigen::Vector2d& unbalance_g, const Eigen::Matrix2d& covariance_g2);

/// The same of a published balance.
bool within_own_uncertainty(const Balance& balance);

}  // namespace roadbalance
