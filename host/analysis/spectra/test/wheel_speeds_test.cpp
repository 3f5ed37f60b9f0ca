#include "host/analysis/spectra/wheel_speeds.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/analyser/test/noise_drive.hpp"

namespace roadbalance {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kInterval_s = 0.1;

Level level(int node, double left_hz, double right_hz) {
  return {.node = test::car().node[static_cast<std::size_t>(node)].id,
          .seconds = kInterval_s,
          .rotation_hz = {left_hz, right_hz}};
}

/// Turns a second of each wheel of the demo's car, whose front node reads both front wheels.
struct Rates {
  double fl, fr, rl, rr;
};
void drive(WheelSpeeds& speeds, const Rates& rates, double seconds) {
  for (int k = 0; k < std::lround(seconds / kInterval_s); ++k) {
    speeds.take(level(1, rates.rl, rates.rr));
    speeds.take(level(0, rates.fl, rates.fr));
  }
}

TEST(WheelSpeeds, TellSlipDriftAndOccupancyOfAKnownDrive) {
  const VehicleConfig& car = test::car();
  WheelSpeeds speeds(car);
  drive(speeds, {10.1, 9.9, 10.0, 10.0}, 20.0);
  drive(speeds, {15.15, 14.85, 15.0, 15.0}, 40.0);
  const auto wheels = speeds.wheels();
  EXPECT_NEAR(wheels[0].slip, 0.01, 1e-9);
  EXPECT_NEAR(wheels[1].slip, -0.01, 1e-9);
  EXPECT_NEAR(wheels[2].slip, 0.0, 1e-9);
  EXPECT_NEAR(wheels[0].turns, 20.0 * 10.1 + 40.0 * 15.15, 1e-6);
  EXPECT_NEAR(wheels[3].seconds, 60.0, 1e-6);
  EXPECT_NEAR(speeds.drift_rad(0, 1), kTurn * (20.0 * 0.2 + 40.0 * 0.3), 1e-6);
  EXPECT_NEAR(speeds.drift_rad(1, 0), speeds.drift_rad(0, 1), 0.0);
  EXPECT_NEAR(speeds.drift_rad(2, 3), 0.0, 1e-9);
  double all_s = 0.0;
  for (const auto& [place, seconds] : speeds.classes()) all_s += seconds;
  EXPECT_NEAR(all_s, 60.0, 1e-6);
  double mean_m_s = 0.0;
  for (int w = 0; w < kWheels; ++w)
    mean_m_s += kTurn * car.wheel[static_cast<std::size_t>(w)].rolling_radius_m *
                (w == 0   ? 15.15
                 : w == 1 ? 14.85
                          : 15.0) /
                4;
  EXPECT_NEAR(speeds.classes().at(static_cast<int>(mean_m_s / speeds.class_m_s())), 40.0, 1e-6);
}

/// By a record whose times are damaged; a class is an int.
TEST(WheelSpeeds, ASpeedThatNoCarReachesIsOfTheLastClass) {
  WheelSpeeds speeds(test::car());
  drive(speeds, {1e12, 1e12, 1e12, 1e12}, 1.0);
  ASSERT_EQ(speeds.classes().size(), 1U);
  EXPECT_EQ(speeds.classes().begin()->first, WheelSpeeds::kLastClass);
  drive(speeds, {-1e12, -1e12, -1e12, -1e12}, 1.0);
  EXPECT_EQ(speeds.classes().begin()->first, -WheelSpeeds::kLastClass);
}

TEST(WheelSpeeds, DriftIsTheArcAndNotTheWay) {
  WheelSpeeds speeds(test::car());
  drive(speeds, {10.0, 10.1, 10, 10}, 5.0);
  drive(speeds, {10.1, 10.0, 10, 10}, 5.0);
  EXPECT_NEAR(speeds.drift_rad(0, 1), kTurn * 0.5, 1e-9);
}

TEST(WheelSpeeds, WhatIsNotKnownIsNotSaid) {
  WheelSpeeds speeds(test::car());
  drive(speeds, {10.0, NAN, 10.0, 10.0}, 5.0);
  EXPECT_TRUE(std::isnan(speeds.drift_rad(0, 1)));
  EXPECT_FALSE(std::isnan(speeds.drift_rad(0, 2)));
  EXPECT_TRUE(std::isnan(speeds.wheels()[0].slip)) << "against the mean of all, one of which is not known";
  EXPECT_EQ(speeds.wheels()[1].seconds, 0.0);
  // The last report of a silent node is not what its wheels do now.
  WheelSpeeds silent(test::car());
  silent.take(level(1, 10.0, 10.0));
  for (int k = 0; k < 100; ++k) silent.take(level(0, 10.0, 10.0));
  EXPECT_NEAR(silent.wheels()[2].seconds, kInterval_s, 1e-9);
  EXPECT_NEAR(silent.drift_rad(0, 2), 0.0, 1e-9);
  EXPECT_NEAR(silent.wheels()[0].slip, 0.0, 1e-9);
}

}  // namespace
}  // namespace roadbalance
