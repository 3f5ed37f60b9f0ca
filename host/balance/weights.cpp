#include "host/balance/weights.hpp"

#include <Eigen/Dense>
#include <cassert>
#include <cmath>
#include <numbers>

namespace roadbalance {

namespace {

// 95 % of the chi-squared distribution with two degrees of freedom: -2 ln 0.05.
constexpr double kChiSquared95 = 5.991464547107979;

double wrap(double angle_rad) {
  const double turn = 2.0 * std::numbers::pi;
  const double wrapped = std::fmod(angle_rad, turn);
  // A tiny negative angle plus a turn may round to a whole turn.
  const double positive = wrapped < 0.0 ? wrapped + turn : wrapped;
  return positive >= turn ? 0.0 : positive;
}

}  // namespace

WeightPair stock_weights(double mass_g, double angle_rad) {
  assert(mass_g > 0.0);
  const double steps = std::ceil(mass_g / (2.0 * kWeightStepG));
  const double weight_g = steps * kWeightStepG;
  const double spread_rad = std::acos(mass_g / (2.0 * weight_g));
  return {weight_g, {wrap(angle_rad - spread_rad), wrap(angle_rad + spread_rad)}};
}

Counterweight counterweight(double unbalance_g, double heavy_spot_rad) {
  const double angle_rad = wrap(heavy_spot_rad + std::numbers::pi);
  return {unbalance_g, angle_rad, stock_weights(unbalance_g, angle_rad)};
}

bool within_own_uncertainty(const Eigen::Vector2d& unbalance_g, const Eigen::Matrix2d& covariance_g2) {
  return unbalance_g.dot(covariance_g2.ldlt().solve(unbalance_g)) <= kChiSquared95;
}

bool within_own_uncertainty(const Balance& balance) {
  return within_own_uncertainty(
      balance.unbalance_g * Eigen::Vector2d(std::cos(balance.angle_rad), std::sin(balance.angle_rad)),
      balance.covariance_g2);
}

}  // namespace roadbalance
