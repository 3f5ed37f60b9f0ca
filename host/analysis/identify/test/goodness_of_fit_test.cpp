#include "host/analysis/identify/goodness_of_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "host/analysis/identify/confidence.hpp"

namespace roadbalance {
namespace {

/// Residuals of two kinds with this covariance, and the covariance that n groups show of their mean.
struct Draw {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};
Draw draw(std::mt19937_64& random, int n, const Eigen::Vector2d& truth) {
  std::normal_distribution<double> normal;
  Eigen::Matrix2d mix;
  mix << 1.0, 0.0, 0.8, 0.4;
  std::vector<Eigen::Vector2d> groups;
  Draw result;
  for (int g = 0; g < n; ++g) {
    groups.push_back(truth + mix * Eigen::Vector2d(normal(random), normal(random)));
    result.mean += groups.back() / n;
  }
  for (const auto& group : groups)
    result.covariance += (group - result.mean) * (group - result.mean).transpose() / (n * (n - 1.0));
  return result;
}

TEST(GoodnessOfFit, FindsAChanceOfFivePercentInFivePercentOfSoundCars) {
  for (const int n : {6, 12, 40}) {
    std::mt19937_64 random(1);
    constexpr int kDraws = 20'000;
    int rare = 0;
    for (int k = 0; k < kDraws; ++k) {
      const Draw seen = draw(random, n, Eigen::Vector2d::Zero());
      rare += goodness_of_fit(seen.mean, seen.covariance, {1.0, 1.0}, n).chance < 0.05;
    }
    // Exact by Hotelling; four standard deviations of a proportion.
    EXPECT_NEAR(static_cast<double>(rare) / kDraws, 0.05, 4.0 * std::sqrt(0.05 * 0.95 / kDraws)) << n;
  }
}

TEST(GoodnessOfFit, SaysHowLargeTheCauseWouldHaveToBe) {
  std::mt19937_64 random(2);
  const Eigen::Vector2d grows(3.0, -2.0);
  const double cause = 0.25;
  constexpr int kDraws = 4000, kGroups = 40;
  double sum = 0.0, squares = 0.0, stated = 0.0;
  for (int k = 0; k < kDraws; ++k) {
    const Draw seen = draw(random, kGroups, -cause * grows);
    const GoodnessOfFit fit = goodness_of_fit(seen.mean, seen.covariance, grows, kGroups);
    EXPECT_NEAR(fit.gain.dot(seen.mean), fit.share, 1e-12);
    sum += fit.share / kDraws;
    squares += fit.share * fit.share / kDraws;
    stated += fit.sigma_share / kDraws;
  }
  const double sigma = std::sqrt(squares - sum * sum);
  EXPECT_NEAR(sum, cause, 4.0 * sigma / std::sqrt(kDraws));
  EXPECT_NEAR(stated / sigma, 1.0, 0.08);  // estimated weights cost 1.3 %, the widening adds 5 %
}

TEST(GoodnessOfFit, JudgesNothingByTooFewGroupsOrWithoutScatter) {
  const Eigen::Matrix2d unit = Eigen::Matrix2d::Identity();
  EXPECT_EQ(goodness_of_fit({9.0, 9.0}, unit, {1.0, 0.0}, 3).chance, 1.0);
  EXPECT_EQ(goodness_of_fit({9.0, 9.0}, Eigen::Matrix2d::Zero(), {1.0, 0.0}, 30).sigma_share, 0.0);
}

/// The mean of n groups of 30 residuals that go together by fives and differ in size, and the means without
/// one group each.
struct ManyResiduals {
  static constexpr int kMany = 30;
  Eigen::VectorXd mean;
  Eigen::MatrixXd left_out;
  ManyResiduals(std::mt19937_64& random, int n, double systematic) {
    std::normal_distribution<double> normal;
    Eigen::MatrixXd all(kMany, n);
    for (int g = 0; g < n; ++g)
      for (int five = 0; five < kMany / 5; ++five) {
        const double common = normal(random);
        for (int k = 0; k < 5; ++k) {
          const double size = 1.0 + five;
          all(5 * five + k, g) = size * (0.6 * common + 0.8 * normal(random) + systematic);
        }
      }
    mean = all.rowwise().mean();
    left_out = (-all + n * mean.replicate(1, n)) / (n - 1.0);
  }
};

double share_below_five_percent(int n, double systematic, double allowed) {
  std::mt19937_64 random(5);
  constexpr int kDraws = 4000;
  int rare = 0;
  for (int k = 0; k < kDraws; ++k) {
    const ManyResiduals drawn(random, n, systematic);
    rare += chance_of_residuals(drawn.mean, drawn.left_out, n, allowed) < 0.05;
  }
  return static_cast<double>(rare) / kDraws;
}

TEST(ChanceOfResiduals, IsBelowFivePercentInFivePercentOfSoundCars) {
  // The distribution is an approximation: within a quarter of what it says, and four sigmas of a proportion.
  for (const int n : {10, 20, 40}) EXPECT_NEAR(share_below_five_percent(n, 0.0, 0.0), 0.05, 0.026) << n;
}

TEST(ChanceOfResiduals, SeesWhatEachResidualAloneHides) {
  // Half a sigma of the mean in each of thirty: no single one stands out.
  EXPECT_GT(share_below_five_percent(40, 0.6 / std::sqrt(40.0), 0.0), 0.25);
  EXPECT_GT(share_below_five_percent(40, 1.2 / std::sqrt(40.0), 0.0), 0.8);
}

TEST(ChanceOfResiduals, SaysNothingAgainstWhatIsAllowed) {
  // Its length is sum size^2 5 s^2 = 455 s^2.
  const double systematic = 1.2 / std::sqrt(40.0);
  EXPECT_LT(share_below_five_percent(40, systematic, 2.0 * std::sqrt(455.0) * systematic), 0.1);
}

TEST(ChanceOfResiduals, SeesThreeTimesWhatIsAllowed) {
  // However quiet the noise is: a road without end hides nothing.
  for (const double sigmas : {2.0, 20.0}) {
    const double systematic = sigmas / std::sqrt(40.0);
    EXPECT_GT(share_below_five_percent(40, systematic, std::sqrt(455.0) * systematic / 3.0), 0.8) << sigmas;
  }
}

// The definition: an ellipse so widened holds the truth in 95 of 100 cases however few the groups.
TEST(FewGroupsFactor, MakesTheEllipseHoldNinetyFivePercent) {
  for (const int n : {5, 10, 32}) {
    std::mt19937_64 random(3);
    constexpr int kDraws = 20'000;
    int within = 0;
    for (int k = 0; k < kDraws; ++k) {
      const Draw seen = draw(random, n, Eigen::Vector2d::Zero());
      const Eigen::Matrix2d wide = few_groups_factor(n) * seen.covariance;
      within += seen.mean.dot(wide.inverse() * seen.mean) <= 5.991464547;
    }
    EXPECT_NEAR(static_cast<double>(within) / kDraws, 0.95, 4.0 * std::sqrt(0.05 * 0.95 / kDraws)) << n;
  }
  EXPECT_NEAR(few_groups_factor(1e6), 1.0, 1e-5);
}

}  // namespace
}  // namespace roadbalance
