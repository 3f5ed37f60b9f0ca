#include "host/analysis/orders/mean_vector.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace roadbalance {
namespace {

double limit_of(int vectors) {
  const double m = vectors - 2;
  const double f = 0.5 * m * (std::pow(0.05, -2.0 / m) - 1.0);
  return 2.0 * (vectors - 1) / m * f;
}

Confidence about(const Eigen::Vector2d& mean, const Eigen::Matrix2d& covariance, int vectors) {
  Confidence result{covariance, limit_of(vectors), 0.0, std::nullopt};
  const double length = mean.norm();
  if (length == 0.0) {
    result.amplitude = std::sqrt(result.limit * covariance.trace());
    return result;
  }
  const Eigen::Vector2d along = mean / length, across(-along(1), along(0));
  result.amplitude = std::sqrt(result.limit * along.dot(covariance * along));
  // Vectors that do not scatter at all leave no doubt; their covariance has no inverse.
  const Eigen::Matrix2d reach = result.limit * covariance;
  const double determinant = reach.determinant();
  const bool holds_zero =
      determinant > 0.0 ? mean.dot(reach.inverse() * mean) <= 1.0 : reach.trace() >= length * length;
  if (holds_zero) return result;
  // The tangents from the origin to the ellipse touch it at this angle from its centre where it is a circle;
  // for an ellipse this is right to second order.
  const double half_width = std::sqrt(across.dot(reach * across));
  result.phase_rad = std::asin(std::min(1.0, half_width / length));
  return result;
}

}  // namespace

void MeanVector::add(std::complex<double> value) {
  Eigen::Vector2d x(value.real(), value.imag());
  for (Level& level : level_) {
    ++level.count;
    const Eigen::Vector2d before = x - level.mean;
    level.mean += before / level.count;
    level.squares += before * (x - level.mean).transpose();
    if (!level.unpaired) {
      level.unpaired = x;
      return;
    }
    x = 0.5 * (x + *level.unpaired);
    level.unpaired.reset();
  }
}

std::optional<Confidence> MeanVector::confidence() const {
  if (count() < kLeastVectors) return std::nullopt;
  const Level* used = nullptr;
  Eigen::Matrix2d largest = Eigen::Matrix2d::Zero();
  for (const Level& level : level_) {
    if (used && level.count < kLeastBatches) break;
    const Eigen::Matrix2d covariance = level.squares / (static_cast<double>(level.count) * (level.count - 1));
    if (used && covariance.trace() <= largest.trace()) continue;
    used = &level;
    largest = 0.5 * (covariance + covariance.transpose());
  }
  return about(level_[0].mean, largest, used->count);
}

}  // namespace roadbalance
