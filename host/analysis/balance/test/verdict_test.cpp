#include "host/analysis/balance/verdict.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace roadbalance {
namespace {

Balance wheel(double unbalance_g) {
  Balance balance;
  balance.state = Unknown::kNone;
  balance.unbalance_g = unbalance_g;
  balance.weight_radius_m = 0.19;
  balance.covariance_g2 = Eigen::Vector2d(1.0, 3.0).asDiagonal();
  balance.least_speed_m_s = 60.0 / 3.6;
  balance.greatest_speed_m_s = 140.0 / 3.6;
  return balance;
}
WeightPlan opposite(const Balance& balance, double grams) {
  return {{}, -std::polar(grams * balance.weight_radius_m, balance.angle_rad)};
}

// ISO 21940-11: a rotor of 40 kg at 3000 1/min in grade G 6.3 may have 802 g mm (e_per = 20 um).
TEST(PermissibleUnbalance, IsThatOfTheStandard) {
  EXPECT_NEAR(permissible_unbalance_g_mm(6.3, 40.0, 3000.0), 9549.0 * 6.3 * 40.0 / 3000.0, 0.1);
}

TEST(JudgeBalance, ExpectsWhatIsLeftAndWhatIsNotKnown) {
  const Balance balance = wheel(30.0);
  const BalanceVerdict verdict = judge_balance(balance, opposite(balance, 27.0), 20.0, 0.30);
  EXPECT_NEAR(verdict.residual_g, std::sqrt(9.0 + 4.0), 1e-12);
  EXPECT_TRUE(verdict.within_shop());
  EXPECT_FALSE(judge_balance(balance, {}, 20.0, 0.30).within_shop());
  // 140 km/h on 0.30 m: 1237.9 1/min; 9549 * 40 * 20 / 1237.9 = 6171 g mm at 190 mm.
  EXPECT_NEAR(verdict.permissible_g, 32.48, 0.02);
  EXPECT_NEAR(verdict.grade_mm_s, 40.0 * verdict.residual_g / verdict.permissible_g, 1e-9);
  EXPECT_TRUE(verdict.incurable.empty());
  EXPECT_EQ(verdict.force_left_share, 1.0) << "nobody knows";
}

TEST(JudgeBalance, SaysThatWeightsWillNotCureAForce) {
  Balance balance = wheel(30.0);
  balance.force_state = ForceState::kSeparated;
  balance.force_n = 150.0;
  balance.sigma_force_n = 10.0;
  EXPECT_NE(judge_balance(balance, opposite(balance, 30.0), 20.0, 0.30).incurable.find("150 ± 10 N"),
            std::string::npos);
  // A small one that is all there is.
  balance.force_n = 40.0;
  balance.alone_g = 1.0;
  const BalanceVerdict verdict = judge_balance(balance, {}, 20.0, 0.30);
  EXPECT_NEAR(verdict.force_left_share, 1.0, 1e-9);
  EXPECT_NE(verdict.incurable.find("dominates"), std::string::npos);
  // One that is small beside the unbalance.
  balance.alone_g = 30.0;
  EXPECT_TRUE(judge_balance(balance, opposite(balance, 30.0), 20.0, 0.30).incurable.empty());
  // With the unbalance alone gone the force stays: mean squares over the band by its antiderivative.
  const double u = 1e-3 * 30.0 * 0.19, r = 40.0, a = 60.0 / 3.6 / 0.3, b = 140.0 / 3.6 / 0.3;
  const auto integral = [&](double w) {
    return u * u * std::pow(w, 5) / 5.0 + 2.0 * u * r * std::pow(w, 3) / 3.0 + r * r * w;
  };
  EXPECT_NEAR(judge_balance(balance, opposite(balance, 30.0), 20.0, 0.30).force_left_share,
              std::sqrt(r * r * (b - a) / (integral(b) - integral(a))), 1e-5);
}

TEST(JudgeBalance, SaysThatASoundWheelNeedsNoSuchWeight) {
  Balance balance = wheel(80.0);
  balance.sigma_g = 9.9;
  EXPECT_NE(judge_balance(balance, {}, 20.0, 0.30).incurable.find("80 ± 10 g is more than the 60 g"),
            std::string::npos);
  balance.sigma_g = 10.1;
  EXPECT_EQ(judge_balance(balance, {}, 20.0, 0.30).incurable, "") << "60 g lie within two sigma";
}

// 2.4 g of standard deviation 1 lie inside their own 95 % ellipse, which reaches to 2.45 g.
TEST(JudgeBalance, SaysOfAWheelThatMayHaveNoneOnlyThatItsForceIsTooLarge) {
  Balance balance = wheel(2.4);
  balance.sigma_g = 1.0;
  const BalanceLimits limits{.heaviest_g = 0.3};
  EXPECT_EQ(judge_balance(balance, {}, 20.0, 0.30, limits).incurable, "");
  balance.force_state = ForceState::kSeparated;
  balance.force_n = 20.0;
  balance.sigma_force_n = 1.0;
  EXPECT_EQ(judge_balance(balance, {}, 20.0, 0.30, limits).incurable, "");
  balance.force_n = 150.0;
  EXPECT_NE(judge_balance(balance, {}, 20.0, 0.30, limits).incurable.find("150 ± 1 N"), std::string::npos);
  balance.unbalance_g = 2.5;
  balance.force_n = 20.0;
  EXPECT_NE(judge_balance(balance, {}, 20.0, 0.30, limits).incurable, "");
}

// The definition of the ellipse: of estimates of nothing it holds 95 in 100.
TEST(WithinOwnUncertainty, HoldsForNinetyFivePercentOfPureNoise) {
  Eigen::Matrix2d factor;
  factor << 2.0, 0.0, 1.2, 0.5;
  Balance balance;
  balance.covariance_g2 = factor * factor.transpose();
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  const int runs = 20'000;
  int within = 0;
  for (int i = 0; i < runs; ++i) {
    const Eigen::Vector2d noise = factor * Eigen::Vector2d(normal(random), normal(random));
    balance.unbalance_g = noise.norm();
    balance.angle_rad = std::atan2(noise.y(), noise.x());
    within += within_own_uncertainty(balance);
  }
  // Four standard deviations of a binomial proportion.
  EXPECT_NEAR(static_cast<double>(within) / runs, 0.95, 4.0 * std::sqrt(0.95 * 0.05 / runs));
}

}  // namespace
}  // namespace roadbalance
