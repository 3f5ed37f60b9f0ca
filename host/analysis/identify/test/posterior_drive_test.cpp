#include <gtest/gtest.h>

#include <random>

#include <Eigen/LU>

#include "common/vehicle/sensor_map.hpp"
#include "host/analysis/identify/drive_posterior.hpp"
#include "host/analysis/identify/refusal.hpp"
#include "sim/drawn_car.hpp"
#include "tools/study/estimator_trial.hpp"
#include "tools/study/ideal_drive.hpp"
#include "tools/study/real_drive.hpp"

namespace roadbalance {
namespace {

constexpr std::uint64_t kSeed = 5;
constexpr double kNoise_m_s2 = 0.02;
constexpr double kGain = 0.01;  ///< car_of_a_stranger's sigma

struct Case {
  const char* name;
  void (*change)(sim::Scenario& scenario);
  double gain = 0.0;  ///< drawn with this sigma; none: only the posterior does not know that they are exact
};

class PosteriorOfADrive : public testing::TestWithParam<Case> {};

/// (x - truth)' C^-1 (x - truth)
double squares(std::complex<double> difference, const Eigen::Matrix2d& covariance) {
  const Eigen::Vector2d parts(difference.real(), difference.imag());
  return parts.dot(covariance.inverse() * parts);
}

using Kind = UncertainQuantity::Kind;
Eigen::Vector4d of(const PosteriorCar& car, Kind kind) {
  Eigen::Vector4d all = Eigen::Vector4d::Zero();
  for (const Deviation& deviation : car.deviations)
    if (deviation.quantity.kind == kind) all(deviation.quantity.index) = deviation.value;
  return all;
}

// 64 s at each of four speeds on a road of class A, where a case says so by sensors whose gains are drawn.
// Nothing is said of the road's shape, nor of a car whose masses are drawn from what is known of them.
TEST_P(PosteriorOfADrive, HoldsTyresAndForcesWhateverTheRoad) {
  const VehicleConfig vehicle = car_of_a_stranger();
  IdealDrive drive{.scenario = sim::Scenario::read("", vehicle), .speeds_m_s = {}, .samples = 64 * 500};
  for (const double speed : {90.0, 103.0, 117.0, 130.0}) drive.speeds_m_s.push_back(speed / 3.6);
  GetParam().change(drive.scenario);
  const sim::DrawnCar truth = sim::draw_car(drive.scenario, kSeed, vehicle);
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  const CarPrior prior = CarPrior::of(vehicle);
  const Eigen::VectorXd gains = Eigen::VectorXd::NullaryExpr(
      prior.sensors.rows(), [&] { return 1.0 + GetParam().gain * normal(random); });
  const Eigen::MatrixXd to_coordinates = SensorMap::from(vehicle).pseudo_inverse;
  DrivePosterior posterior(prior, vehicle.drive.speed_class_m_s);
  SectionBuilder sections(
      vehicle, [&](const DrivenSection& section) { posterior.add(section); }, prior.sensors);
  Eigen::Vector4d square = Eigen::Vector4d::Zero(), fourth = Eigen::Vector4d::Zero();
  for (Stretch& stretch : drive_ideally(drive, kSeed, vehicle)) {
    stretch.readings = gains.asDiagonal() * stretch.readings;
    for (double& value : stretch.readings.reshaped()) value += kNoise_m_s2 * normal(random);
    stretch.signals.topRows<kCoordinates>() = to_coordinates * stretch.readings;
    for (Eigen::Index k = 0; k < stretch.signals.cols(); ++k)
      sections.consume(
          {.signals = stretch.signals.col(k), .readings = stretch.readings.col(k), .restart = k == 0});
    square += stretch.omega.cwiseAbs2();
    fourth += stretch.omega.cwiseAbs2().cwiseAbs2();
  }
  const auto found = posterior.solve();
  ASSERT_TRUE(found);
  if (drive.scenario.damper.is_linear()) {
    EXPECT_LT(of(*found, Kind::kFriction).cwiseAbs().maxCoeff(), 3.0);
    EXPECT_LT(of(*found, Kind::kRebound).cwiseAbs().maxCoeff(), 0.03);
  } else {
    const double half = 0.5 * (drive.scenario.damper.rebound - drive.scenario.damper.compression);
    for (int i = 0; i < kWheels; ++i) {
      EXPECT_NEAR(of(*found, Kind::kFriction)(i), drive.scenario.damper.friction_n, 4.0) << i;
      EXPECT_NEAR(of(*found, Kind::kRebound)(i), half, 0.03) << i;
    }
  }
  double tyres = 0.0;
  for (int p = kSpring; p < kTyreDamper; ++p) {
    const double error = std::log(found->parameters(p) / truth.parameters(p));
    const double sigma = found->sigma(p) / found->parameters(p);
    EXPECT_LT(std::abs(error), 4.0 * sigma) << p;
    if (p < kTyre) continue;
    tyres += error * error / (sigma * sigma);
    if (GetParam().gain == 0.0) {
      EXPECT_LT(std::abs(error), 0.03) << p;
    }
  }
  EXPECT_LT(tyres, 18.5);          // chi^2 of four: one in a thousand
  constexpr double kOfTwo = 16.6;  // chi^2 of two, which one in a thousand of the four wheels exceeds
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    const sim::WheelScenario& wheel = truth.wheel[w];
    const WheelFirstOrder& first_order = found->wheel[w];
    const auto correction = wheel.unbalance_kg_m + wheel.radial_force_n * square(i) / fourth(i);
    EXPECT_LT(squares(first_order.correction_kg_m - correction, first_order.correction_covariance), kOfTwo)
        << i;
    EXPECT_LT(squares(first_order.unbalance_kg_m - wheel.unbalance_kg_m, first_order.unbalance_covariance),
              kOfTwo)
        << i;
    EXPECT_LT(squares(first_order.force_n - wheel.radial_force_n, first_order.force_covariance), kOfTwo) << i;
    EXPECT_LT(std::abs(first_order.correction_kg_m - correction) / vehicle.wheel[w].weight_radius_m, 2.5e-3)
        << i;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Worlds, PosteriorOfADrive,
    testing::Values(Case{"2.0", [](sim::Scenario&) {}},
                    Case{"1.5", [](sim::Scenario& s) { s.road.waviness = {.below = 1.5}; }},
                    Case{"2.5", [](sim::Scenario& s) { s.road.waviness = {.below = 2.5}; }},
                    Case{"1.5, 3 beyond 0.4",
                         [](sim::Scenario& s) {
                           s.road.waviness = {.below = 1.5, .above = 3.0, .bend_1_m = 0.4};
                         }},
                    Case{"1.6 left, 2.6 right",
                         [](sim::Scenario& s) {
                           s.road.waviness = {.below = 1.6, .above = 1.6};
                           s.road.right_waviness = 1.0;
                         }},
                    Case{"3.0", [](sim::Scenario& s) { s.road.waviness = {.below = 3.0}; }, kGain},
                    Case{"potholes",
                         [](sim::Scenario& s) {
                           s.road.pothole = {3.0, {-0.045, -0.045}};
                         },
                         kGain},
                    Case{"friction of 50 N", [](sim::Scenario& s) { s.damper.friction_n = 50.0; }, kGain},
                    Case{"dampers 1 : 3",
                         [](sim::Scenario& s) {
                           s.damper.compression = 0.5;
                           s.damper.rebound = 1.5;
                         },
                         kGain},
                    Case{"masses drawn", [](sim::Scenario& s) { s.sigma_spread = 1.0; }, kGain},
                    Case{"radial forces",
                         [](sim::Scenario& s) {
                           s.tyre.radial_force_n[0] = {20.0, 60.0};
                         },
                         kGain}));

// A road so smooth, and sensors so noisy, that most of what is measured is noise: there is no estimate, or
// its ellipses hold.
TEST(PosteriorOfANoisyDrive, IsNoneOrHoldsTheTruth) {
  constexpr double kLoud_m_s2 = 0.5, kOfTwo = 16.6;
  const VehicleConfig vehicle = car_of_a_stranger();
  IdealDrive drive{.scenario = sim::Scenario::read("", vehicle), .speeds_m_s = {}, .samples = 64 * 500};
  for (const double speed : {90.0, 103.0, 117.0, 130.0}) drive.speeds_m_s.push_back(speed / 3.6);
  drive.scenario.road.roughness_m3 /= 50.0;
  const sim::DrawnCar truth = sim::draw_car(drive.scenario, kSeed, vehicle);
  const CarPrior prior = CarPrior::of(vehicle);
  const Eigen::MatrixXd to_coordinates = SensorMap::from(vehicle).pseudo_inverse;
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> noise(0.0, kLoud_m_s2);
  DrivePosterior posterior(prior, vehicle.drive.speed_class_m_s);
  SectionBuilder sections(
      vehicle, [&](const DrivenSection& section) { posterior.add(section); }, prior.sensors);
  for (Stretch& stretch : drive_ideally(drive, kSeed, vehicle)) {
    for (double& value : stretch.readings.reshaped()) value += noise(random);
    stretch.signals.topRows<kCoordinates>() = to_coordinates * stretch.readings;
    for (Eigen::Index k = 0; k < stretch.signals.cols(); ++k)
      sections.consume(
          {.signals = stretch.signals.col(k), .readings = stretch.readings.col(k), .restart = k == 0});
  }
  const auto found = posterior.solve();
  if (!refusal(found, prior, vehicle).empty()) return;
  for (std::size_t w = 0; w < kWheels; ++w)  // the car has no radial forces
    EXPECT_LT(squares(found->wheel[w].correction_kg_m - truth.wheel[w].unbalance_kg_m,
                      found->wheel[w].correction_covariance),
              kOfTwo)
        << w;
}

}  // namespace
}  // namespace roadbalance
