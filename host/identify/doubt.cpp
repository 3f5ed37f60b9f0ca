#include "host/identify/doubt.hpp"

#include <cmath>

namespace roadbalance {

void add_doubt(Balance& balance, double along, double across) {
  const Eigen::Vector2d vector =
      balance.unbalance_g * Eigen::Vector2d(std::cos(balance.angle_rad), std::sin(balance.angle_rad));
  const Eigen::Vector2d turned(-vector.y(), vector.x());
  balance.covariance_g2 += along * vector * vector.transpose() + across * turned * turned.transpose();
  balance.sigma_g = std::hypot(balance.sigma_g, balance.unbalance_g * std::sqrt(along));
  balance.sigma_rad = std::hypot(balance.sigma_rad, std::sqrt(across));
}

}  // namespace roadbalance
