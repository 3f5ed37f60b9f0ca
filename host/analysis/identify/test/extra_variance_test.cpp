#include "host/analysis/identify/extra_variance.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace roadbalance {
namespace {

TEST(AddVariance, IsTheSumOfSquaresAlongAndAcrossTheUnbalance) {
  Balance balance;
  balance.unbalance_g = 20.0;
  balance.angle_rad = 0.7;
  balance.covariance_g2 = 0.25 * Eigen::Matrix2d::Identity();
  balance.sigma_g = 0.5;
  balance.sigma_rad = 0.5 / 20.0;
  add_variance(balance, 0.03 * 0.03, 0.05 * 0.05);
  EXPECT_NEAR(balance.sigma_g, std::sqrt(0.25 + 0.36), 1e-12);
  EXPECT_NEAR(balance.sigma_rad, std::sqrt(0.025 * 0.025 + 0.05 * 0.05), 1e-12);
  // The ellipse says the same of both directions, and they do not depend on each other.
  const Eigen::Vector2d along(std::cos(0.7), std::sin(0.7)), across(-along.y(), along.x());
  EXPECT_NEAR(along.dot(balance.covariance_g2 * along), balance.sigma_g * balance.sigma_g, 1e-12);
  EXPECT_NEAR(across.dot(balance.covariance_g2 * across), std::pow(20.0 * balance.sigma_rad, 2), 1e-12);
  EXPECT_NEAR(along.dot(balance.covariance_g2 * across), 0.0, 1e-12);
}

ChannelConfig sensor(const std::string& mount, double gain_sigma, Eigen::Vector3d direction = {0, 0, 1}) {
  ChannelConfig channel;
  channel.mount = mount;
  channel.gain_sigma = gain_sigma;
  channel.direction = direction;
  return channel;
}

// The signal of a wheel's own vertical sensor is in proportion to its unbalance; of n sensors the mean
// counts.
TEST(GainVariance, IsThatOfTheVerticalSensorsOnTheCarrierOrElseOnTheBody) {
  VehicleConfig vehicle;
  vehicle.node.push_back({"front", 1, 2000.0, {}, {}});
  auto& channels = vehicle.node[0].channel;
  EXPECT_EQ(gain_variance(vehicle, 0), 0.0);
  for (const double gain_sigma : {0.01, 0.02, 0.02, 0.03}) channels.push_back(sensor("body", gain_sigma));
  EXPECT_NEAR(gain_variance(vehicle, 0), (1e-4 + 4e-4 + 4e-4 + 9e-4) / 16.0, 1e-15);
  channels.push_back(sensor("front_left", 0.02));
  channels.push_back(sensor("front_left", 0.30, {1, 0, 0}));
  EXPECT_NEAR(gain_variance(vehicle, 0), 4e-4, 1e-15);
  channels.push_back(sensor("front_left", 0.04));
  EXPECT_NEAR(gain_variance(vehicle, 0), (4e-4 + 16e-4) / 4.0, 1e-15);
  EXPECT_NEAR(gain_variance(vehicle, 1), (1e-4 + 4e-4 + 4e-4 + 9e-4) / 16.0, 1e-15);
}

}  // namespace
}  // namespace roadbalance
