#include "host/analysis/identify/publish_estimate.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include "common/types/angle_units.hpp"

namespace roadbalance {
namespace {

double sigma(const UnknownMatrix& covariance, int i) {
  return std::sqrt(covariance(i, i));
}

double positive(double angle_rad) {
  return angle_rad < 0.0 ? angle_rad + kTurn : angle_rad;
}

}  // namespace

void put_suspension(const UnknownVector& x, const UnknownMatrix& covariance, Identification& result) {
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    result.spring_n_m[w] = x(kEstimatedSpring + i);
    result.sigma_spring_n_m[w] = sigma(covariance, kEstimatedSpring + i);
    result.damper_n_s_m[w] = x(kEstimatedDamper + i);
    result.sigma_damper_n_s_m[w] = sigma(covariance, kEstimatedDamper + i);
    result.tyre_n_m[w] = x(kEstimatedTyre + i);
    result.sigma_tyre_n_m[w] = sigma(covariance, kEstimatedTyre + i);
  }
  for (int a = 0; a < kAxles; ++a) {
    result.stabiliser_n_m[static_cast<std::size_t>(a)] = x(kEstimatedStabiliser + a);
    result.sigma_stabiliser_n_m[static_cast<std::size_t>(a)] = sigma(covariance, kEstimatedStabiliser + a);
  }
}

void put_covariance(const EstimateCovariance& covariance, Identification& result) {
  result.condition = covariance.suspension.condition;
  for (std::size_t k = 0; k < covariance.fit.size(); ++k) {
    result.misfit[k] = covariance.fit[k].square;
    result.misfit_chance[k] = covariance.fit[k].chance;
    result.mass_share[k] = k == 0 ? covariance.mass_share : covariance.fit[k].share;
    result.sigma_mass_share[k] = k == 0 ? covariance.sigma_mass_share : covariance.fit[k].sigma_share;
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

void put_first_order(const FirstOrderFit& fit, Balance& balance) {
  balance.force_state = fit.separable ? ForceState::kSeparated : ForceState::kNotSeparable;
  if (!fit.separable) return;
  const double grams = 1000.0 / balance.weight_radius_m;  // per kg m
  balance.force_n = std::abs(fit.force_n);
  balance.force_angle_rad = positive(std::arg(fit.force_n));
  balance.sigma_force_n = fit.sigma_force_n;
  balance.alone_g = grams * std::abs(fit.unbalance_kg_m);
  balance.alone_angle_rad = positive(std::arg(fit.unbalance_kg_m));
  balance.sigma_alone_g = grams * fit.sigma_unbalance_kg_m;
}

}  // namespace roadbalance
