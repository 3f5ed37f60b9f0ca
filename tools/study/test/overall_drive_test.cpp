// The prediction of overall compensation for a drive, against the same car driven again with its weights.
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <complex>
#include <numbers>

#include "host/analysis/balance/overall_plan.hpp"
#include "host/analysis/identify/estimate_covariance.hpp"
#include "tools/study/test/gathered_drive.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using Unbalances = std::array<Complex, kWheels>;  ///< kg m

/// The demonstration car with two seats and two tyres out of round, on a road of a tenth of the amplitude of
/// class A, which has as much information on the car and ten times as much on the wheels.
class OverallDrive : public testing::Test {
 protected:
  OverallDrive() {
    vehicle_.seat = {{"driver", {0.1, 0.35, 0.2}, 1.0}, {"behind", {-0.9, -0.35, 0.2}, 0.5}};
    drive_.scenario.wheel[0].radial_force_n = std::polar(30.0, 1.0);
    drive_.scenario.wheel[1].radial_force_n = std::polar(15.0, -2.0);
    drive_.scenario.wheel[3].unbalance_kg_m = 0.0;
    drive_.scenario.road.roughness_m3 *= 0.01;
    const Priors known = Priors::of(vehicle_);
    const SpeedClasses classes = test::gather(drive_, kSeed, vehicle_);
    const UnknownVector x = solve(classes.total(), known.geometry, known.value).value();
    std::array<Compensation, kWheels>& opposite = by_wheel_;  // exact weights: no rounding
    for (std::size_t w = 0; w < kWheels; ++w) {
      const auto at = kEstimatedUnbalance + 2 * static_cast<int>(w);
      opposite_[w] = -Complex(x(at), x(at + 1));
      opposite[w].advice = Advice::kSteps;
      opposite[w].plan.applied_g_m = 1e3 * opposite_[w];
    }
    opposite[3].advice = Advice::kLeaveUncertain;
    opposite[3].plan = {};
    opposite_[3] = 0.0;
    forces_ = drive_forces(classes.totals(), x, known);
    plan_ = plan_overall(forces_, vehicle_, opposite);
  }

  /// Drives the car with these weights where the road is flat, so that all that moves turns with the wheels,
  /// and takes the wheels' lines from the seats' vertical acceleration by least squares.  Rms at each speed,
  /// then of all.
  std::vector<double> felt_with(const Unbalances& weight) const {
    IdealDrive drive = drive_;
    drive.scenario.road.roughness_m3 = 0.0;
    for (std::size_t w = 0; w < kWheels; ++w) drive.scenario.wheel[w].unbalance_kg_m += weight[w];
    std::vector<double> felt;
    double squares = 0.0, weights = 0.0;
    for (const SeatConfig& seat : vehicle_.seat) weights += seat.weight;
    for (const Stretch& stretch : drive_ideally(drive, kSeed, vehicle_)) {
      const Eigen::MatrixXd lines = stretch.signals.bottomRows<2 * kWheels>().transpose();
      double square = 0.0;
      for (const SeatConfig& seat : vehicle_.seat) {
        const Eigen::VectorXd up = stretch.signals.row(0) + seat.position_m.y() * stretch.signals.row(1) -
                                   seat.position_m.x() * stretch.signals.row(2);
        square += seat.weight * 0.5 * lines.colPivHouseholderQr().solve(up).squaredNorm();
      }
      felt.push_back(std::sqrt(square / weights));
      squares += square / weights;
    }
    felt.push_back(std::sqrt(squares / static_cast<double>(felt.size())));
    return felt;
  }
  Unbalances bought() const {
    Unbalances weight;
    for (std::size_t w = 0; w < kWheels; ++w) weight[w] = 1e-3 * plan_.wheel[w].plan.applied_g_m;
    return weight;
  }

  static constexpr std::uint64_t kSeed = 6;
  VehicleConfig vehicle_ = test::demo_car();
  IdealDrive drive_ = test::plateaus({60, 80, 100, 120, 140}, 120);
  Unbalances opposite_{};
  std::array<Compensation, kWheels> by_wheel_{};
  DriveForces forces_{};
  OverallPlan plan_;
};

TEST_F(OverallDrive, PredictsWhatTheSeatsWillFeel) {
  const auto now = felt_with({}), by_wheel = felt_with(opposite_), overall = felt_with(bought());
  ASSERT_EQ(plan_.speed.size() + 1, now.size());
  for (std::size_t s = 0; s < now.size(); ++s) {
    const SeatVibration& predicted = s < plan_.speed.size() ? plan_.speed[s].vibration : plan_.vibration;
    // Tyres and forces of these drives are good to 1 %.
    EXPECT_NEAR(predicted.now, now[s], 0.02 * now[s]);
    EXPECT_NEAR(predicted.by_wheel, by_wheel[s], 0.02 * now[s]);
    EXPECT_NEAR(predicted.overall, overall[s], 0.02 * now[s]);
  }
}

// Each wheel shakes at a frequency of its own, so mean squares add.
TEST_F(OverallDrive, IsTheSumOfItsWheels) {
  double now = 0.0, left = 0.0;
  for (const WheelVibration& wheel : wheel_vibration(forces_, vehicle_, by_wheel_)) {
    now += wheel.now * wheel.now;
    left += wheel.left * wheel.left;
  }
  EXPECT_NEAR(std::sqrt(now), plan_.vibration.now, 1e-12);
  EXPECT_NEAR(std::sqrt(left), plan_.vibration.by_wheel, 1e-12);
  EXPECT_LT(left, 0.1 * now);
}

TEST_F(OverallDrive, OfAWheelThatTellsNothingNothingIsSaid) {
  for (SpeedForces& speed : forces_.speed) speed.wheel[2].variance_n2 = 0.0;
  const auto felt = wheel_vibration(forces_, vehicle_, by_wheel_);
  EXPECT_TRUE(std::isnan(felt[2].now));
  EXPECT_TRUE(std::isnan(felt[2].left));
  EXPECT_GT(felt[0].now, 0.0);
}

TEST_F(OverallDrive, AWheelWithoutForceIsNamedAndKeepsItsOwnWeights) {
  forces_.speed[1].wheel[0].variance_n2 = 0.0;
  for (SpeedForces& speed : forces_.speed) speed.wheel[2].variance_n2 = 0.0;
  const OverallPlan plan = plan_overall(forces_, vehicle_, by_wheel_);
  for (std::size_t s = 0; s < plan.speed.size(); ++s) {
    EXPECT_EQ(plan.speed[s].without_force[0], s == 1);
    EXPECT_TRUE(plan.speed[s].without_force[2]);
    EXPECT_FALSE(plan.speed[s].without_force[1]);
    EXPECT_TRUE(plan_.speed[s].without_force.none());
  }
  EXPECT_EQ(plan.wheel[2].plan.applied_g_m, by_wheel_[2].plan.applied_g_m);
  EXPECT_NE(plan.wheel[2].plan.applied_g_m, 0.0);
  EXPECT_EQ(plan.wheel[2].best.mass_g, 0.0);
}

/// Tyres out of round have their share in the equivalent unbalance of each wheel, so its opposite is nearly
/// as good; the opposite of the unbalance alone leaves all that they do.
TEST_F(OverallDrive, LeavesLeastOfAllWeights) {
  const double overall = felt_with(bought()).back();
  EXPECT_LT(overall, felt_with(opposite_).back());
  Unbalances opposite_of_truth{};
  for (std::size_t w = 0; w < kWheels; ++w) opposite_of_truth[w] = -drive_.scenario.wheel[w].unbalance_kg_m;
  EXPECT_LT(overall, 0.5 * felt_with(opposite_of_truth).back());
  for (const std::size_t w : {0U, 1U})
    for (int quarter = 0; quarter < 4; ++quarter) {
      Unbalances other = bought();
      other[w] += std::polar(0.003 * 0.19, 0.5 * std::numbers::pi * quarter);  // 3 g
      EXPECT_LT(overall, felt_with(other).back()) << w << ' ' << quarter;
    }
}

TEST_F(OverallDrive, LeavesAWheelAloneThatMayHaveNoUnbalance) {
  EXPECT_EQ(plan_.wheel[3].best.mass_g, 0.0);
  EXPECT_TRUE(plan_.wheel[3].plan.step.empty());
  EXPECT_FALSE(plan_.wheel[0].plan.step.empty());
}

TEST(Seats, AreTheVerticalSensorsOnTheBodyIfNoneIsNamed) {
  const auto seats = seats_of(test::demo_car());
  ASSERT_EQ(seats.size(), 4U);
  EXPECT_EQ(seats[0].name, "fl_strut_z");
  EXPECT_EQ(seats[0].position_m, Eigen::Vector3d(1.25, 0.592, 0.4));
  EXPECT_EQ(seats[3].weight, 1.0);
}

}  // namespace
}  // namespace roadbalance
