#include "host/analysis/calibration/trial_weight.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kWorst_rad = 20.0 * kDegree;
/// A wrong wheel mass or radius is in no covariance.
constexpr double kScaleTolerance = 0.05;

Eigen::Vector2d across(const Eigen::Vector2d& along) {
  return {-along.y(), along.x()};
}

}  // namespace

FoundUnbalance FoundUnbalance::from(const Balance& balance, const EncoderConfig& encoder) {
  const Eigen::Vector2d vector =
      balance.unbalance_g * Eigen::Vector2d(std::cos(balance.angle_rad), std::sin(balance.angle_rad));
  const Eigen::Vector2d turned = encoder.datum_sigma_rad * across(vector);
  return {vector, balance.covariance_g2 - turned * turned.transpose(), encoder.datum_rad};
}

std::optional<TrialDatum> datum_by_trial_weight(const FoundUnbalance& before, const FoundUnbalance& after,
                                                const TrialWeight& weight) {
  const Eigen::Matrix2d of_before = Eigen::Rotation2Dd(before.datum_rad).toRotationMatrix();
  const Eigen::Matrix2d of_after = Eigen::Rotation2Dd(after.datum_rad).toRotationMatrix();
  const Eigen::Vector2d change = of_after * after.unbalance_g - of_before * before.unbalance_g;
  const Eigen::Matrix2d covariance = of_after * after.covariance_g2 * of_after.transpose() +
                                     of_before * before.covariance_g2 * of_before.transpose();
  const double length = change.norm();
  const Eigen::Vector2d along = change / length;
  const double sideways = std::sqrt(across(along).dot(covariance * across(along))) / length;
  if (!(sideways < kWorst_rad)) return std::nullopt;
  const double angle = std::atan2(change.y(), change.x());
  return TrialDatum{std::remainder(angle - weight.angle_rad, 2.0 * std::numbers::pi),
                    std::hypot(sideways, weight.angle_sigma_rad), length,
                    std::sqrt(along.dot(covariance * along))};
}

bool TrialDatum::mass_agrees(const TrialWeight& weight) const {
  return std::abs(change_g - weight.mass_g) <= 3.0 * change_sigma_g + kScaleTolerance * weight.mass_g;
}

}  // namespace roadbalance
