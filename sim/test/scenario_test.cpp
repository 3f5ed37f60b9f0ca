#include "sim/scenario.hpp"

#include <gtest/gtest.h>

#include <algorithm>
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

TEST(Scenario, DrawsAKeyGivenByItsBoundsByTheSeed) {
  const auto drawn = [](std::uint64_t seed) {
    return Scenario::parse(kShortest + "[road]\nwaviness = [1.5, 3.3]\nrear_coherence2 = [0.5, 0.98]\n",
                           "test.toml", test::reference_vehicle(), seed)
        .road;
  };
  double least = 4.0, most = 0.0, least_coherence = 1.0, product = 0.0;
  constexpr int kSeeds = 400;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const RoadScenario road = drawn(seed);
    EXPECT_EQ(road.waviness.above, road.waviness.below);
    least = std::min(least, road.waviness.below);
    most = std::max(most, road.waviness.below);
    least_coherence = std::min(least_coherence, road.rear_coherence2);
    product += (road.waviness.below - 2.4) / 1.8 * (road.rear_coherence2 - 0.74) / 0.48 * 12.0 / kSeeds;
  }
  EXPECT_GE(least, 1.5);
  EXPECT_LE(most, 3.3);
  // Of 400 none within 2 % of a bound: once in 3000.
  EXPECT_LT(least, 1.5 + 0.02 * 1.8);
  EXPECT_GT(most, 3.3 - 0.02 * 1.8);
  EXPECT_LT(least_coherence, 0.5 + 0.02 * 0.48);
  EXPECT_NEAR(product, 0.0, 4.0 / std::sqrt(kSeeds)) << "each key has a sequence of its own";
  EXPECT_EQ(drawn(7).waviness.below, drawn(7).waviness.below);
}

TEST(Scenario, RefusesBoundsThatAreNone) {
  for (const char* bounds : {"[3, 2]", "[2]", "[1.5, 2, 3]", "[0, 2]", "\"2\"", "[]"})
    EXPECT_THROW(parse(kShortest + "[road]\nwaviness = " + bounds + "\n"), ConfigError) << bounds;
}

TEST(Scenario, KeepsTheMeanOfADamperOfWhichItDrawsTheRatio) {
  const DamperScenario damper = parse(kShortest + "[damper]\nrebound_ratio = 3\n").damper;
  EXPECT_DOUBLE_EQ(damper.compression, 0.5);
  EXPECT_DOUBLE_EQ(damper.rebound, 1.5);
}

TEST(Scenario, DrawsMassesInertiasAndTyreDampersByTheirDeviations) {
  VehicleConfig vehicle = test::reference_vehicle();
  vehicle.model.body_mass_sigma_kg = 39.0;
  vehicle.model.roll_inertia_sigma_kg_m2 = 48.0;
  vehicle.wheel[1].mass_sigma_kg = 0.7;
  const Scenario scenario = Scenario::parse(kShortest + "[spread]\nsigmas = 1\n", "test.toml", vehicle);
  ParameterVector square = ParameterVector::Zero();
  constexpr int kSeeds = 2000;
  const ParameterVector nominal = nominal_parameters(vehicle);
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed)
    square += (draw_car(scenario, seed, vehicle).parameters - nominal).cwiseAbs2() / kSeeds;
  // A variance of 2000 values is good to sqrt(2 / 2000) = 3.2 %.
  EXPECT_NEAR(square(kBodyMass) / (39.0 * 39.0), 1.0, 0.15);
  EXPECT_NEAR(square(kRollInertia) / (48.0 * 48.0), 1.0, 0.15);
  EXPECT_NEAR(square(kWheelMass + 1) / (0.7 * 0.7), 1.0, 0.15);
  EXPECT_EQ(square(kWheelMass), 0.0) << "it is known exactly";
}

TEST(Scenario, DrawsForcesOfTyresForEachWheel) {
  const Scenario scenario =
      parse(kShortest + "[tyre]\nradial_force_1_n = [10, 60]\nradial_force_3_n = 5\n" +
            "[[radial_force]]\nwheel = \"rear_left\"\nforce_n = 30\nangle_deg = 90\norder = 2\n");
  const DrawnCar car = draw_car(scenario, 3, test::reference_vehicle());
  for (std::size_t i = 0; i < kWheels; ++i) {
    EXPECT_GE(std::abs(car.wheel[i].radial_force_n), 10.0);
    EXPECT_LE(std::abs(car.wheel[i].radial_force_n), 60.0);
    EXPECT_NEAR(std::abs(car.wheel[i].higher_radial_force_n[1]), 5.0, 1e-12);
    EXPECT_NEAR(std::abs(car.wheel[i].higher_radial_force_n[0]), i == 2 ? 30.0 : 0.0, 1e-12);
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GT(std::abs(car.wheel[i].radial_force_n - car.wheel[j].radial_force_n), 0.1);
  }
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
