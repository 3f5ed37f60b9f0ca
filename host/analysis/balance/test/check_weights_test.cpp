#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "host/analysis/balance/check_weights.hpp"

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kRadius_m = 0.19;
constexpr std::size_t kWheel = 1;

std::complex<double> at(double grams, double degrees) {
  return std::polar(grams, degrees * kDegree);
}

/// One wheel known to 1 g in each direction.
BalancedDrive drive(std::complex<double> unbalance_g) {
  BalancedDrive drive{.name = "a drive", .vehicle = {}, .balance = {}, .compensation = {}};
  drive.vehicle.name = "a car";
  for (std::size_t w = 0; w < kWheels; ++w) {
    drive.vehicle.wheel[w].mass_kg = 34.0;
    drive.balance[w].weight_radius_m = kRadius_m;
  }
  Balance& balance = drive.balance[kWheel];
  balance.state = Unknown::kNone;
  balance.unbalance_g = std::abs(unbalance_g);
  balance.angle_rad = std::arg(unbalance_g);
  balance.covariance_g2 = Eigen::Matrix2d::Identity();
  return drive;
}

/// 35 g at 217 degrees, for which 35 g at 37 were advised.
BalancedDrive before() {
  BalancedDrive result = drive(at(35.0, 217.0));
  result.compensation[kWheel].advice = Advice::kSteps;
  result.compensation[kWheel].plan.applied_g_m = kRadius_m * at(35.0, 37.0);
  return result;
}

WeightCheck after(std::complex<double> unbalance_g) {
  return check_weights(before(), drive(unbalance_g))[kWheel];
}

TEST(CheckWeights, TellsWhatTheyHaveDone) {
  const WeightCheck found = after(at(2.0, 80.0));
  EXPECT_EQ(found.state, WeightCheckState::kKnown);
  EXPECT_EQ(found.verdict, WeightCheckVerdict::kGood);
  EXPECT_EQ(found.placement, WeightPlacement::kAsWanted);
  EXPECT_FALSE(found.fitted_known);
  EXPECT_NEAR(found.reduction, 1.0 - 2.0 / 35.0, 1e-12);
  // Sigma of a / b with 1 g each: (1 / b) sqrt(1 + (a / b)^2).
  EXPECT_NEAR(found.sigma_reduction, std::sqrt(1.0 + 4.0 / 1225.0) / 35.0, 1e-12);
  EXPECT_NEAR(found.fitted_g.x(), at(35.0, 37.0).real(), 1e-12);
  EXPECT_EQ(found.text, "a drive");
}

TEST(CheckWeights, TellsWhichMistakeWasMade) {
  // Counted against the rotation, 37 degrees are -37.
  EXPECT_EQ(after(at(35.0, 217.0) + at(35.0, -37.0)).placement, WeightPlacement::kMirrored);
  EXPECT_EQ(after(at(70.0, 217.0)).placement, WeightPlacement::kOpposite);
  EXPECT_EQ(after(at(35.5, 217.0)).placement, WeightPlacement::kNoEffect);
  EXPECT_EQ(after(at(35.0, 217.0) + at(35.0, 130.0)).placement, WeightPlacement::kElsewhere);
}

TEST(CheckWeights, JudgesWhatIsLeft) {
  EXPECT_EQ(after(at(70.0, 217.0)).verdict, WeightCheckVerdict::kMore);
  EXPECT_EQ(after(at(35.5, 217.0)).verdict, WeightCheckVerdict::kUnchanged);
  EXPECT_EQ(after(at(20.0, 217.0)).verdict, WeightCheckVerdict::kLess);
  // 6.9 g are within 7, but not with what is not known of them.
  EXPECT_EQ(after(at(6.9, 0.0)).verdict, WeightCheckVerdict::kLess);
  BalancedDrive unclear = drive(at(34.0, 217.0));
  unclear.balance[kWheel].covariance_g2 *= 100.0;
  EXPECT_EQ(check_weights(before(), unclear)[kWheel].verdict, WeightCheckVerdict::kOpen);
}

TEST(CheckWeights, GoesByTheWeightsThatVehicleTomlTellsOf) {
  BalancedDrive then = before(), now = drive(at(35.0, 217.0) + at(20.0, 100.0));
  then.vehicle.wheel[kWheel].fitted = {{10.0, 1.0, kRadius_m}};
  now.vehicle.wheel[kWheel].fitted = {{10.0, 1.0, kRadius_m}, {20.0, 100.0 * kDegree, kRadius_m}};
  const WeightCheck found = check_weights(then, now)[kWheel];
  EXPECT_TRUE(found.fitted_known);
  EXPECT_EQ(found.placement, WeightPlacement::kAsWanted);
  EXPECT_NEAR(found.fitted_g.norm(), 20.0, 1e-9);
}

TEST(CheckWeights, SaysNothingOfWeightsThatCannotBeSeen) {
  BalancedDrive then = before();
  then.compensation[kWheel].plan.applied_g_m = kRadius_m * at(4.0, 37.0);  // chi^2 = 16 / 2 < 9.2
  EXPECT_EQ(check_weights(then, drive(at(35.0, 217.0)))[kWheel].placement, WeightPlacement::kNotJudged);
  then.compensation[kWheel].advice = Advice::kLeaveSmall;
  EXPECT_EQ(check_weights(then, drive(at(35.0, 217.0)))[kWheel].fitted_g.norm(), 0.0);
}

TEST(CheckWeights, NeverMixesDrivesWhoseAnglesOrGramsAreOfAnotherKind) {
  const auto state_with = [](auto change) {
    BalancedDrive then = before();
    change(then.vehicle, then.vehicle.wheel[kWheel]);
    return check_weights(then, drive(at(2.0, 0.0)))[kWheel];
  };
  EXPECT_EQ(state_with([](auto&, auto&) {}).state, WeightCheckState::kKnown);
  for (const auto& other : {state_with([](auto&vehicle, auto&) { vehicle.name = "b"; }),
                            state_with([](auto&, auto&wheel) { wheel.encoder.datum_rad = 0.01; }),
                            state_with([](auto&, auto&wheel) { wheel.encoder.pulses_per_turn = 48; }),
                            state_with([](auto&, auto&wheel) { wheel.encoder.steering_ratio = 1.0; }),
                            state_with([](auto&, auto&wheel) { wheel.mass_kg = 33.0; })}) {
    EXPECT_EQ(other.state, WeightCheckState::kNotComparable);
    EXPECT_NE(other.text, "");
    EXPECT_EQ(other.after_g.norm() + other.before_g.norm(), 0.0)
        << "no number of one beside one of the other";
  }
}

TEST(CheckWeights, KnowsBetweenWhichDrivesWeightsWereFitted) {
  BalancedDrive then = before(), now = before();
  EXPECT_FALSE(weights_were_fitted_between(then.vehicle, now.vehicle));
  now.vehicle.wheel[2].fitted = {{20.0, 1.0, kRadius_m}};
  EXPECT_TRUE(weights_were_fitted_between(then.vehicle, now.vehicle));
  then.vehicle.wheel[2].fitted = {{10.0, 1.0, kRadius_m}, {10.0, 1.0, kRadius_m}};
  EXPECT_FALSE(weights_were_fitted_between(then.vehicle, now.vehicle)) << "two of 10 g are one of 20";
  then.vehicle.wheel[2].fitted.clear();
  then.vehicle.wheel[0].encoder.datum_rad = 0.1;
  EXPECT_FALSE(weights_were_fitted_between(then.vehicle, now.vehicle));
}

TEST(CheckWeights, WaitsForBothDrives) {
  BalancedDrive then = before(), now = drive(at(2.0, 0.0));
  now.balance[kWheel].state = Unknown::kTooShort;
  EXPECT_EQ(check_weights(then, now)[kWheel].state, WeightCheckState::kAfterUnknown);
  EXPECT_NEAR(check_weights(then, now)[kWheel].before_g.norm(), 35.0, 1e-9);
  then.balance[kWheel].state = Unknown::kInStep;
  EXPECT_EQ(check_weights(then, now)[kWheel].state, WeightCheckState::kBeforeUnknown);
  now.balance[3].time_ns = 17;
  EXPECT_EQ(reading_before("x", now.balance)[3].state, WeightCheckState::kReadingBefore);
  EXPECT_EQ(reading_before("x", now.balance)[3].time_ns, 17)
      << "else it stands beside another recording's balance";
}

TEST(CheckWeights, TellsGramsAtTheRadiusOfTheDriveAfter) {
  BalancedDrive now = drive(at(2.0, 0.0));
  now.balance[kWheel].weight_radius_m = 0.5 * kRadius_m;
  const WeightCheck found = check_weights(before(), now)[kWheel];
  EXPECT_NEAR(found.before_g.norm(), 70.0, 1e-9);
  EXPECT_NEAR(found.fitted_g.norm(), 70.0, 1e-9);
  EXPECT_NEAR(found.before_covariance_g2(0, 0), 4.0, 1e-12);
}

// Weights that are where they should be are reported elsewhere in one drive of a hundred at most: of 4000
// the binomial distribution has 40 +- 6.3.
TEST(CheckWeights, DoubtsRightWeightsSeldom) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> gram;
  int doubted = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    BalancedDrive then = before();
    const auto noise = [&] { return std::complex<double>(gram(random), gram(random)); };
    const std::complex<double> measured = at(35.0, 217.0) + noise();
    then.balance[kWheel].unbalance_g = std::abs(measured);
    then.balance[kWheel].angle_rad = std::arg(measured);
    doubted += check_weights(then, drive(noise()))[kWheel].placement != WeightPlacement::kAsWanted;
  }
  EXPECT_LE(doubted, 40 + 3 * 6.3);
}

}  // namespace
}  // namespace roadbalance
