#include "host/balance/weights.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::complex<double> sum_of(const WeightPair& pair) {
  return std::polar(pair.weight_g, pair.angle_rad[0]) + std::polar(pair.weight_g, pair.angle_rad[1]);
}

TEST(StockWeights, TogetherAreTheMassAndAngleAskedForExactly) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> mass(0.1, 150.0);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * std::numbers::pi);
  for (int i = 0; i < 1000; ++i) {
    const double mass_g = mass(random);
    const double angle_rad = angle(random);
    const WeightPair pair = stock_weights(mass_g, angle_rad);
    // Rounding only; near mass = 2 m the arc cosine loses half the digits of the angle, not of the sum.
    EXPECT_LT(std::abs(sum_of(pair) - std::polar(mass_g, angle_rad)), 1e-11 * mass_g + 1e-12);
    EXPECT_EQ(std::fmod(pair.weight_g, kWeightStepG), 0.0);
    // The smallest that can: one step less would not reach the mass even side by side.
    EXPECT_LT(2.0 * (pair.weight_g - kWeightStepG), mass_g);
  }
}

TEST(StockWeights, LieSideBySideWhenTheMassIsAMultipleOfTwoSteps) {
  const WeightPair pair = stock_weights(30.0, 37.0 * kDegree);
  EXPECT_DOUBLE_EQ(pair.weight_g, 15.0);
  EXPECT_DOUBLE_EQ(pair.angle_rad[0], 37.0 * kDegree);
  EXPECT_DOUBLE_EQ(pair.angle_rad[1], 37.0 * kDegree);
}

TEST(Counterweight, CancelsTheUnbalance) {
  for (const double heavy_deg : {0.0, 60.0, 179.0, 180.0, 217.0, 359.9}) {
    const Counterweight weight = counterweight(35.0, heavy_deg * kDegree);
    const auto rest = std::polar(35.0, heavy_deg * kDegree) + sum_of(weight.pair);
    EXPECT_LT(std::abs(rest), 1e-11) << heavy_deg;
    EXPECT_GE(weight.angle_rad, 0.0);
    EXPECT_LT(weight.angle_rad, 2.0 * std::numbers::pi);
  }
  EXPECT_NEAR(counterweight(35.0, 217.0 * kDegree).angle_rad, 37.0 * kDegree, 1e-12);
}

// The definition of the ellipse: of estimates of nothing it holds 95 in 100.
TEST(WithinOwnUncertainty, HoldsForNinetyFivePercentOfPureNoise) {
  Eigen::Matrix2d factor;
  factor << 2.0, 0.0, 1.2, 0.5;
  const Eigen::Matrix2d covariance_g2 = factor * factor.transpose();
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  const int runs = 20'000;
  int within = 0;
  for (int i = 0; i < runs; ++i)
    within += within_own_uncertainty(factor * Eigen::Vector2d(normal(random), normal(random)), covariance_g2);
  // Four standard deviations of a binomial proportion.
  EXPECT_NEAR(static_cast<double>(within) / runs, 0.95, 4.0 * std::sqrt(0.95 * 0.05 / runs));
}

TEST(WithinOwnUncertainty, UsesTheCovarianceOfTheDirectionOfTheUnbalance) {
  Balance balance;
  balance.unbalance_g = 5.0;
  balance.covariance_g2 = Eigen::Vector2d(1.0, 100.0).asDiagonal();
  balance.angle_rad = 0.0;
  EXPECT_FALSE(within_own_uncertainty(balance));
  balance.angle_rad = 90.0 * kDegree;
  EXPECT_TRUE(within_own_uncertainty(balance));
}

}  // namespace
}  // namespace roadbalance
