#include "sim/damper.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "sim/car.hpp"
#include "sim/test/test_car.hpp"

namespace roadbalance::sim {
namespace {

constexpr double kStep_s = 1.0 / 4000.0;

Geometry geometry() {
  return geometry_of(test::reference_vehicle().model);
}
ParameterVector parameters() {
  return nominal_parameters(test::reference_vehicle());
}
Dampers dampers(const DamperScenario& law) {
  return Dampers(law, geometry(), parameters());
}

/// Wheels shaken at 2, 13 and 18 Hz, left and right differently: struts move at up to some 0.4 m/s.
WheelForces forces(double t) {
  WheelForces f;
  for (int i = 0; i < kWheels; ++i)
    for (const double hz : {2.0, 13.0, 18.0}) {
      const double w = 2.0 * std::numbers::pi * hz, phase = w * t + 1.3 * i + hz;
      f.force_n(i) += 400.0 * std::cos(phase);
      f.rate_n_s(i) -= 400.0 * w * std::sin(phase);
    }
  return f;
}

/// z'' over two seconds, a column a step.
Eigen::Matrix<double, kCoordinates, Eigen::Dynamic> drive(VehicleDynamics dynamics) {
  constexpr int kSteps = 8000;
  Eigen::Matrix<double, kCoordinates, Eigen::Dynamic> motion(kCoordinates, kSteps);
  dynamics.reset(forces(0.0));
  for (int k = 0; k < kSteps; ++k) {
    dynamics.step(forces((k + 1) * kStep_s));
    motion.col(k) = dynamics.acceleration();
  }
  return motion;
}

TEST(Damper, ForceIsTheOneOfTheLaw) {
  const DamperScenario linear, degressive{.knee_m_s = 0.3}, rubs{.friction_n = 40.0};
  const DamperScenario asymmetric{.compression = 0.5, .rebound = 1.5};
  const auto force = [](const DamperScenario& law, double v) { return 1500.0 * v + law.excess_n(1500.0, v); };
  for (const double v : {-0.7, -0.01, 0.0, 0.2}) EXPECT_EQ(linear.excess_n(1500.0, v), 0.0);
  EXPECT_DOUBLE_EQ(force(degressive, 0.3), 0.5 * 1500.0 * 0.3);
  EXPECT_DOUBLE_EQ(force(degressive, -0.6), -1500.0 * 0.6 / 3.0);
  EXPECT_DOUBLE_EQ(force(asymmetric, 0.2), 1.5 * 1500.0 * 0.2);
  EXPECT_DOUBLE_EQ(force(asymmetric, -0.2), -0.5 * 1500.0 * 0.2);
  EXPECT_NEAR(force(rubs, 0.1), 150.0 + 40.0, 1e-9);
  EXPECT_NEAR(force(rubs, -0.1), -150.0 - 40.0, 1e-9);
}

TEST(Damper, LinearOnesLeaveEverySampleAsItIs) {
  const LinearModel model = linear_model(geometry(), parameters());
  EXPECT_EQ(drive(VehicleDynamics(model, dampers({}), kStep_s)), drive(VehicleDynamics(model, kStep_s)));
}

// Twice 1.2 is a linear damper again, of which the dynamics take the fifth part as a force of the law.
TEST(Damper, EqualSharesAreALinearCarWithOtherDampers) {
  ParameterVector stiffer = parameters();
  stiffer.segment<kWheels>(kDamper) *= 1.2;
  const auto found = drive(VehicleDynamics(linear_model(geometry(), parameters()),
                                           dampers({.compression = 1.2, .rebound = 1.2}), kStep_s));
  const auto expected = drive(VehicleDynamics(linear_model(geometry(), stiffer), kStep_s));
  EXPECT_GT((drive(VehicleDynamics(linear_model(geometry(), parameters()), kStep_s)) - expected).norm(),
            0.02 * expected.norm());
  // (w h)^2 / 12 at 18 Hz of a force that is a part of all.
  EXPECT_LT((found - expected).norm(), 7e-5 * expected.norm());
}

// By the classical Runge-Kutta method from the equations as they are written, at a step of a sixteenth.
TEST(Damper, BentAndRubbingOnesMoveTheCarAsTheEquationsSay) {
  const LinearModel model = linear_model(geometry(), parameters());
  const DamperScenario law{.compression = 0.5, .rebound = 1.5, .knee_m_s = 0.3, .friction_n = 40.0};
  const auto found = drive(VehicleDynamics(model, dampers(law), kStep_s));

  const Geometry places = geometry();
  using State = Eigen::Matrix<double, 2 * kCoordinates, 1>;
  const Matrix7 inverse = model.M.inverse();
  const auto rate = [&](double t, const State& s) {
    Vector7 force = model.W * forces(t).force_n - model.P * s.tail<7>() - model.Q * s.head<7>();
    for (int i = 0; i < kWheels; ++i) {
      const auto w = static_cast<std::size_t>(i);
      const double stretch = s(7) + places.y_m[w] * s(8) - places.x_m[w] * s(9) - s(10 + i);
      const double excess = law.excess_n(parameters()(kDamper + i), stretch);
      force.head<3>() -= excess * Eigen::Vector3d(1.0, places.y_m[w], -places.x_m[w]);
      force(kBodyCoordinates + i) += excess;
    }
    State change;
    change << s.tail<7>(), inverse * force;
    return change;
  };
  constexpr int kFine = 16, kSteps = 2000;
  constexpr double h = kStep_s / kFine;
  State s = State::Zero();
  double error = 0.0, power = 0.0;
  for (int k = 0; k < kFine * kSteps; ++k) {
    const double t = k * h;
    const State k1 = rate(t, s), k2 = rate(t + h / 2, s + h / 2 * k1), k3 = rate(t + h / 2, s + h / 2 * k2),
                k4 = rate(t + h, s + h * k3);
    s += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    if ((k + 1) % kFine != 0) continue;
    const Vector7 expected = rate(t + h, s).tail<7>();
    error += (found.col(k / kFine) - expected).squaredNorm();
    power += expected.squaredNorm();
  }
  // Friction changes sides within some steps: what linear interpolation misses is larger there.
  EXPECT_LT(std::sqrt(error / power), 5e-3);
}

TEST(Damper, TheScenarioSaysWhatTheCarHas) {
  Scenario scenario = test::ideal_scenario(30.0);
  scenario.road = {16e-6, 0.3, 0.95};
  const auto rms = [&](const DamperScenario& law) {
    scenario.damper = law;
    Car car(scenario, 5, test::reference_vehicle(), 1e-3);
    double sum = 0.0;
    for (int k = 0; k < 4000; ++k) {
      car.step();
      sum += car.sources().segment<kWheels>(kCoordinateSource + kBodyCoordinates).squaredNorm();
    }
    return std::sqrt(sum / 4000.0);
  };
  // Wheels hop the more, the less their dampers take.
  EXPECT_GT(rms({.knee_m_s = 0.1}), 1.1 * rms({}));
  EXPECT_LT(rms({.compression = 1.5, .rebound = 1.5}), 0.95 * rms({}));
}

}  // namespace
}  // namespace roadbalance::sim
