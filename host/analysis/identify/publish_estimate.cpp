#include "host/analysis/identify/publish_estimate.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include "common/types/angle_units.hpp"

namespace roadbalance {
namespace {

/// The drive separates a force from an unbalance that it tells three times as well as tyres have it.
constexpr double kToldForce_n = kRadialForceSigma_n / 3.0;

/// Root of the mean variance of the two components.
double component_sigma(const Eigen::Matrix2d& covariance) {
  return std::sqrt(0.5 * covariance.trace());
}

double positive(double angle_rad) {
  return angle_rad < 0.0 ? angle_rad + kTurn : angle_rad;
}

}  // namespace

void put_suspension(const UnknownVector& x, const UnknownVector& sigma, Identification& result) {
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    result.spring_n_m[w] = x(kEstimatedSpring + i);
    result.sigma_spring_n_m[w] = sigma(kEstimatedSpring + i);
    result.damper_n_s_m[w] = x(kEstimatedDamper + i);
    result.sigma_damper_n_s_m[w] = sigma(kEstimatedDamper + i);
    result.tyre_n_m[w] = x(kEstimatedTyre + i);
    result.sigma_tyre_n_m[w] = sigma(kEstimatedTyre + i);
  }
  for (int a = 0; a < kAxles; ++a) {
    result.stabiliser_n_m[static_cast<std::size_t>(a)] = x(kEstimatedStabiliser + a);
    result.sigma_stabiliser_n_m[static_cast<std::size_t>(a)] = sigma(kEstimatedStabiliser + a);
  }
}

void put_unbalance(const Eigen::Vector2d& unbalance_kg_m, const Eigen::Matrix2d& covariance_kg2_m2,
                   Balance& balance) {
  const double grams = 1000.0 / balance.weight_radius_m;  // per kg m
  const Eigen::Vector2d vector = grams * unbalance_kg_m;
  balance.covariance_g2 = grams * grams * covariance_kg2_m2;
  balance.unbalance_g = vector.norm();
  const Eigen::Vector2d radial = vector.normalized();
  const Eigen::Vector2d tangential(-radial.y(), radial.x());
  balance.sigma_g = std::sqrt(radial.dot(balance.covariance_g2 * radial));
  balance.sigma_rad = std::sqrt(tangential.dot(balance.covariance_g2 * tangential)) / balance.unbalance_g;
  balance.angle_rad = positive(std::atan2(vector.y(), vector.x()));
  balance.weight_angle_rad = std::fmod(balance.angle_rad + std::numbers::pi, kTurn);
}

void put_first_order(const WheelFirstOrder& wheel, double widened, Balance& balance) {
  const double grams = 1000.0 / balance.weight_radius_m;  // per kg m
  balance.force_n = std::abs(wheel.force_n);
  balance.force_angle_rad = positive(std::arg(wheel.force_n));
  balance.sigma_force_n = component_sigma(widened * wheel.force_covariance);
  balance.alone_g = grams * std::abs(wheel.unbalance_kg_m);
  balance.alone_angle_rad = positive(std::arg(wheel.unbalance_kg_m));
  balance.sigma_alone_g = grams * component_sigma(widened * wheel.unbalance_covariance);
  balance.force_state =
      balance.sigma_force_n <= kToldForce_n ? ForceState::kSeparated : ForceState::kNotSeparable;
}

}  // namespace roadbalance
