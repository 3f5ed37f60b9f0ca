#include "sim/scenario.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/config/section.hpp"
#include "sim/test/test_car.hpp"
#include "sim/truth.hpp"

namespace roadbalance::sim {
namespace {

const std::string kShortest = "[[drive.plateau]]\nspeed_km_h = 100\nseconds = 30\n";

Scenario parse(const std::string& text) {
  return Scenario::parse(text, "test.toml", test::reference_vehicle());
}

TEST(Scenario, DemoIsWhatTheReadoutIsComparedWith) {
  const VehicleConfig vehicle = test::reference_vehicle();
  const Truth truth = truth_of("", 1, vehicle);
  EXPECT_NEAR(truth.wheel[0].unbalance_g, 35.0, 1e-9);
  EXPECT_NEAR(truth.wheel[0].angle_deg, 217.0, 1e-9);
  EXPECT_NEAR(truth.wheel[1].unbalance_g, 20.0, 1e-9);
  EXPECT_NEAR(truth.wheel[1].angle_deg, 60.0, 1e-9);
  for (const std::size_t rear : {2U, 3U}) {
    EXPECT_GE(truth.wheel[rear].unbalance_g, 10.0);
    EXPECT_LE(truth.wheel[rear].unbalance_g, 15.0);
  }
  const Scenario scenario = Scenario::read("", vehicle);
  EXPECT_EQ(scenario.road.roughness_m3, 16e-6);
  EXPECT_EQ(scenario.drive.plateau.size(), 4U);
  EXPECT_DOUBLE_EQ(scenario.drive.plateau.front().speed_m_s, 25.0);
  EXPECT_DOUBLE_EQ(scenario.drive.plateau.back().speed_m_s, 130.0 / 3.6);
  for (const WheelScenario& wheel : scenario.wheel) EXPECT_EQ(std::abs(wheel.radial_force_n), 0.0);
}

TEST(Scenario, ScalesItsPlateausAlike) {
  Scenario scenario = Scenario::read("", test::reference_vehicle());
  scenario.scale_to(40.0);
  EXPECT_DOUBLE_EQ(scenario.seconds(), 40.0);
  for (const Plateau& plateau : scenario.drive.plateau) EXPECT_DOUBLE_EQ(plateau.seconds, 10.0);
}

TEST(Scenario, ADriftEndsAtTheSameSpeedHoweverLongTheDrive) {
  Scenario scenario = parse("[drive]\ndrift_km_h_min = 5\n" + kShortest);
  EXPECT_DOUBLE_EQ(scenario.drive.drift_m_s2, 5.0 / 3.6 / 60.0);
  scenario.scale_to(60.0);
  EXPECT_DOUBLE_EQ(scenario.drive.drift_m_s2, 2.5 / 3.6 / 60.0);
}

TEST(Scenario, MassesOnOneWheelAddAsVectorsAtTheirRadius) {
  const std::string mass = "[[unbalance]]\nwheel = \"rear_left\"\nmass_g = 30\n";
  const Scenario scenario =
      parse(kShortest + mass + "angle_deg = 0\n" + mass + "angle_deg = 90\nradius_m = 0.1\n");
  EXPECT_NEAR(scenario.wheel[2].unbalance_kg_m.real(), 0.030 * 0.19, 1e-15);
  EXPECT_NEAR(scenario.wheel[2].unbalance_kg_m.imag(), 0.030 * 0.10, 1e-15);
}

TEST(Scenario, DampersAreLinearUnlessItSaysOtherwise) {
  EXPECT_TRUE(Scenario::read("", test::reference_vehicle()).damper.is_linear());
  const DamperScenario damper =
      parse(kShortest + "[damper]\ncompression = 0.5\nrebound = 1.5\nknee_m_s = 0.3\nfriction_n = 40\n")
          .damper;
  EXPECT_EQ(damper.compression, 0.5);
  EXPECT_EQ(damper.rebound, 1.5);
  EXPECT_EQ(damper.knee_m_s, 0.3);
  EXPECT_EQ(damper.friction_n, 40.0);
  EXPECT_THROW(parse(kShortest + "[damper]\nfriction_n = -1\n"), ConfigError);
}

TEST(Scenario, DrawsSpringsDampersStabilisersAndTyresWithinTheSpreadAndLeavesMasses) {
  const VehicleConfig vehicle = test::reference_vehicle();
  const ParameterVector nominal = nominal_parameters(vehicle);
  double least = 1.0, most = 1.0, sum = 0.0;
  const int seeds = 200;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const DrawnCar car = truth_of("", seed, vehicle).car;
    for (int p = 0; p < kTyreDamper; ++p) {
      const double ratio = car.parameters(p) / nominal(p);
      if (p < kSpring) {
        EXPECT_EQ(ratio, 1.0);
        continue;
      }
      least = std::min(least, ratio);
      most = std::max(most, ratio);
      sum += (ratio - 1.0) / (seeds * (kTyreDamper - kSpring));
    }
  }
  EXPECT_GE(least, 0.9);
  EXPECT_LT(least, 0.901);
  EXPECT_LE(most, 1.1);
  EXPECT_GT(most, 1.099);
  EXPECT_NEAR(sum, 0.0, 4.5 * 0.1 / std::sqrt(3.0 * seeds * 14));
}

TEST(Scenario, NoTwoWheelsTurnInStep) {
  const VehicleConfig vehicle = test::reference_vehicle();
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const auto radius_m = truth_of("", seed, vehicle).car.rolling_radius_m;
    for (std::size_t i = 0; i < kWheels; ++i) {
      EXPECT_NEAR(radius_m[i], 0.30, 0.30 * 0.003 * (1.0 + 1.0 / 12.0) + 1e-12);
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_GT(std::abs(radius_m[i] - radius_m[j]), 0.30 * 0.0015 * 0.99);
    }
  }
}

void expect_refused(const std::string& text, const std::string& key) {
  try {
    parse(text);
    FAIL() << "accepted: " << text;
  } catch (const ConfigError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("test.toml"), std::string::npos) << message;
    EXPECT_NE(message.find(key), std::string::npos) << message;
  }
}

TEST(Scenario, ErrorsNameTheKey) {
  expect_refused("[drive]\n", "plateau");
  expect_refused("[[drive.plateau]]\nspeed_km_h = 100\n", "seconds");
  expect_refused("[[drive.plateau]]\nspeed_km_h = 900\nseconds = 3\n", "speed_km_h");
  expect_refused("[[drive.plateau]]\nspeed_km_h = 1\nseconds = 3\n", "speed_km_h");
  expect_refused("[drive]\ndrift_km_h_min = 60\n[[drive.plateau]]\nspeed_km_h = 290\nseconds = 30\n",
                 "drift");
  expect_refused(kShortest + "wheels = 3\n", "wheels");
  expect_refused(kShortest + "[road]\nclass = \"F\"\n", "class");
  expect_refused(kShortest + "[road]\nrear_coherence2 = 1.5\n", "rear_coherence2");
  expect_refused(kShortest + "[[unbalance]]\nwheel = \"spare\"\nmass_g = 3\nangle_deg = 1\n", "wheel");
  expect_refused(kShortest + "[[unbalance]]\nwheel = \"rear_left\"\nangle_deg = 1\n", "mass_g");
  expect_refused(kShortest + "[encoder]\nstamp_jitter_us = 1e6\n", "stamp_jitter_us");
  expect_refused(kShortest + "[spread]\nparameters = -0.1\n", "parameters");
  expect_refused(kShortest + "[sensor]\nnoise = 0.1\n", "noise");
}

}  // namespace
}  // namespace roadbalance::sim
