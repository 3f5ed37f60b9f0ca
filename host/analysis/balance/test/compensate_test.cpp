#include "host/analysis/balance/compensate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kRadius_m = 0.19;

WheelConfig wheel() {
  WheelConfig config{};
  config.mass_kg = 34.0;
  config.rolling_radius_m = 0.30;
  config.weight_radius_m = kRadius_m;
  config.stock.place = {{.radius_m = kRadius_m}};
  return config;
}

/// 2 g known in one direction, 1 g in the other.
Balance known(double grams, double degrees) {
  Balance balance;
  balance.wheel = 2;
  balance.time_ns = 77;
  balance.state = Unknown::kNone;
  balance.unbalance_g = grams;
  balance.angle_rad = degrees * kDegree;
  balance.covariance_g2 = Eigen::Vector2d(4.0, 1.0).asDiagonal();
  balance.weight_radius_m = kRadius_m;
  balance.least_speed_m_s = 25.0;
  balance.greatest_speed_m_s = 36.0;
  return balance;
}

TEST(Compensate, LeavesWhatIsLeftAndWhatIsNotKnown) {
  const Compensation found = compensate(known(30.0, 217.0), wheel(), {});
  EXPECT_EQ(found.wheel, 2);
  EXPECT_EQ(found.time_ns, 77);
  EXPECT_EQ(found.radii, 1);
  EXPECT_EQ(found.advice, Advice::kSteps);
  ASSERT_EQ(found.plan.step.size(), 1U);
  EXPECT_EQ(found.plan.step[0].weight.mass_g, 30.0);
  EXPECT_NEAR(found.plan.step[0].weight.angle_rad, 37.0 * kDegree, 1e-12);
  EXPECT_NEAR(found.verdict.residual_g, std::sqrt(4.0 + 1.0), 1e-9);
  EXPECT_TRUE(found.verdict.within_shop());
  EXPECT_EQ(found.verdict.shop_g, 7.0);
}

/// ISO 21940-11's m is the rotor's: 26 of the 34 kg permit 26/34 of the unbalance.
TEST(Compensate, IsJudgedByTheMassOfWhatTurns) {
  const BalanceVerdict whole = compensate(known(30.0, 217.0), wheel(), {}).verdict;
  EXPECT_FALSE(whole.by_rotor);
  WheelConfig config = wheel();
  config.rotating_mass_kg = 26.0;
  const BalanceVerdict rotor = compensate(known(30.0, 217.0), config, {}).verdict;
  EXPECT_TRUE(rotor.by_rotor);
  EXPECT_NEAR(rotor.permissible_g, whole.permissible_g * 26.0 / 34.0, 1e-9);
  EXPECT_NEAR(rotor.grade_mm_s, whole.grade_mm_s * 34.0 / 26.0, 1e-9);
}

TEST(Compensate, HasNoStepsWhileNothingIsKnown) {
  Balance balance = known(30.0, 0.0);
  balance.state = Unknown::kTooShort;
  const Compensation found = compensate(balance, wheel(), {});
  EXPECT_EQ(found.advice, Advice::kUnknown);
  EXPECT_TRUE(found.plan.step.empty());
}

// The 95 % ellipse reaches to sqrt(5.99) sigma: 4.9 g in one direction, 2.45 g in the other.
TEST(Compensate, LeavesAWheelThatMayHaveNoUnbalance) {
  WheelConfig config = wheel();
  config.fitted = {{20.0, 1.0, kRadius_m}};
  for (const auto& [grams, degrees] : {std::pair{4.85, 0.0}, {2.4, 90.0}}) {
    const Compensation found = compensate(known(grams, degrees), config, {});
    EXPECT_EQ(found.advice, Advice::kLeaveUncertain);
    ASSERT_EQ(found.plan.step.size(), 1U);
    EXPECT_EQ(found.plan.step[0].action, WeightAction::kKeep);
    EXPECT_EQ(found.plan.applied_g_m, 0.0);
    EXPECT_NEAR(found.verdict.residual_g, std::sqrt(grams * grams + 5.0), 1e-9);
  }
  EXPECT_EQ(compensate(known(4.95, 0.0), wheel(), {}).advice, Advice::kSteps);
}

TEST(Compensate, LeavesWhatNoWeightLessens) {
  WheelConfig config = wheel();
  config.stock.most = 1;
  EXPECT_EQ(compensate(known(2.6, 90.0), config, {}).advice, Advice::kLeaveSmall)
      << "half a step and a touch";
  EXPECT_EQ(compensate(known(3.1, 90.0), config, {}).advice, Advice::kSteps);
}

TEST(Compensate, KnowsTheWeightsOnTheWheel) {
  WheelConfig config = wheel();
  config.fitted = {{20.0, 90.0 * kDegree, kRadius_m}};
  // Effect of a weight of 20 g at 90 degrees that should be at 50.
  const auto out = std::polar(20.0, 90.0 * kDegree) - std::polar(20.0, 50.0 * kDegree);
  const Compensation found = compensate(known(std::abs(out), std::arg(out) / kDegree), config, {});
  ASSERT_EQ(found.plan.step.size(), 1U);
  EXPECT_EQ(found.plan.step[0].action, WeightAction::kMove);
}

TEST(Compensate, JudgesByTheLimitsOfTheShop) {
  EXPECT_FALSE(compensate(known(30.0, 0.0), wheel(), {.shop_g = 2.0}).verdict.within_shop());
  EXPECT_NE(compensate(known(30.0, 0.0), wheel(), {.heaviest_g = 25.0}).verdict.incurable, "");
}

// Twice the time halves the variance that driving lessens: of 5 g, 4 of them by driving, 3.5 are reached when
// 4^2 has become 3.5^2 - 3^2.
TEST(Compensate, TellsHowLongToDriveForWhatIsWanted) {
  Balance balance = known(30.0, 0.0);
  balance.seconds_used = 100.0;
  balance.sigma_g = 5.0;
  balance.sigma_drive_g = 4.0;
  EXPECT_NEAR(seconds_wanted(balance, 3.5), 100.0 * (16.0 / 3.25 - 1.0), 1e-9);
  EXPECT_EQ(seconds_wanted(balance, 5.0), 0.0);
  EXPECT_TRUE(std::isinf(seconds_wanted(balance, 3.0))) << "3 g stay however long one drives";
  EXPECT_EQ(compensate(balance, wheel(), {.sigma_g = 3.5}).seconds_wanted, seconds_wanted(balance, 3.5));
  EXPECT_EQ(compensate(balance, wheel(), {.sigma_g = 3.5}).wanted_sigma_g, 3.5);
  balance.state = Unknown::kTooShort;
  EXPECT_TRUE(std::isinf(seconds_wanted(balance, 100.0)));
}

}  // namespace
}  // namespace roadbalance
