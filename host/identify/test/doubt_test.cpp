#include "host/identify/doubt.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace roadbalance {
namespace {

TEST(AddDoubt, IsTheSumOfSquaresAlongAndAcrossTheUnbalance) {
  Balance balance;
  balance.unbalance_g = 20.0;
  balance.angle_rad = 0.7;
  balance.covariance_g2 = 0.25 * Eigen::Matrix2d::Identity();
  balance.sigma_g = 0.5;
  balance.sigma_rad = 0.5 / 20.0;
  add_doubt(balance, 0.03 * 0.03, 0.05 * 0.05);
  EXPECT_NEAR(balance.sigma_g, std::sqrt(0.25 + 0.36), 1e-12);
  EXPECT_NEAR(balance.sigma_rad, std::sqrt(0.025 * 0.025 + 0.05 * 0.05), 1e-12);
  // The ellipse says the same of both directions, and they do not depend on each other.
  const Eigen::Vector2d along(std::cos(0.7), std::sin(0.7)), across(-along.y(), along.x());
  EXPECT_NEAR(along.dot(balance.covariance_g2 * along), balance.sigma_g * balance.sigma_g, 1e-12);
  EXPECT_NEAR(across.dot(balance.covariance_g2 * across), std::pow(20.0 * balance.sigma_rad, 2), 1e-12);
  EXPECT_NEAR(along.dot(balance.covariance_g2 * across), 0.0, 1e-12);
}

}  // namespace
}  // namespace roadbalance
