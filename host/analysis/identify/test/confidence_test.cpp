#include "host/analysis/identify/confidence.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>
#include <vector>

namespace roadbalance {
namespace {

/// The mean of n groups of pairs about 0, and the covariance that they show of it.
struct Draw {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};
Draw draw(std::mt19937_64& random, int n) {
  std::normal_distribution<double> normal;
  Eigen::Matrix2d mix;
  mix << 1.0, 0.0, 0.8, 0.4;
  std::vector<Eigen::Vector2d> groups;
  Draw result;
  for (int g = 0; g < n; ++g) {
    groups.push_back(mix * Eigen::Vector2d(normal(random), normal(random)));
    result.mean += groups.back() / n;
  }
  for (const auto& group : groups)
    result.covariance += (group - result.mean) * (group - result.mean).transpose() / (n * (n - 1.0));
  return result;
}

// The definition: an ellipse so widened holds the truth in 95 of 100 cases however few the groups.
TEST(FewGroupsFactor, MakesTheEllipseHoldNinetyFivePercent) {
  for (const int n : {5, 10, 32}) {
    std::mt19937_64 random(3);
    constexpr int kDraws = 20'000;
    int within = 0;
    for (int k = 0; k < kDraws; ++k) {
      const Draw seen = draw(random, n);
      const Eigen::Matrix2d wide = few_groups_factor(n) * seen.covariance;
      within += seen.mean.dot(wide.inverse() * seen.mean) <= 5.991464547;
    }
    EXPECT_NEAR(static_cast<double>(within) / kDraws, 0.95, 4.0 * std::sqrt(0.05 * 0.95 / kDraws)) << n;
  }
  EXPECT_NEAR(few_groups_factor(1e6), 1.0, 1e-5);
}

}  // namespace
}  // namespace roadbalance
