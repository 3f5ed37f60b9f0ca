#include "sim/drive.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace roadbalance::sim {
namespace {

DriveScenario three_speeds(double wander_m_s) {
  return {{{25.0, 40.0}, {36.0, 50.0}, {30.0, 8.0}}, 6.0, wander_m_s};
}

TEST(Drive, SpeedAndAccelerationAreTheDerivativesOfPosition) {
  const Drive drive(three_speeds(0.14), 7);
  const double h = 1e-3;
  for (double t = -5.0; t < 110.0; t += 0.0371) {
    const Motion before = drive.at(t - h), now = drive.at(t), after = drive.at(t + h);
    // Central differences: rounding 1e-12 m / h, and h^2/6 times a third derivative below 2 m/s^3.
    EXPECT_NEAR((after.position_m - before.position_m) / (2.0 * h), now.speed_m_s, 1e-6) << t;
    EXPECT_NEAR((after.speed_m_s - before.speed_m_s) / (2.0 * h), now.acceleration_m_s2, 1e-5) << t;
  }
}

TEST(Drive, HoldsEachPlateauAfterItsRamp) {
  const Drive drive(three_speeds(0.0), 7);
  EXPECT_DOUBLE_EQ(drive.at(-3.0).speed_m_s, 25.0);
  EXPECT_DOUBLE_EQ(drive.at(39.9).speed_m_s, 25.0);
  EXPECT_DOUBLE_EQ(drive.at(43.0).speed_m_s, 30.5);  // half way through the ramp of 6 s
  EXPECT_DOUBLE_EQ(drive.at(46.0).speed_m_s, 36.0);
  EXPECT_DOUBLE_EQ(drive.at(89.9).speed_m_s, 36.0);
  EXPECT_DOUBLE_EQ(drive.at(94.0).speed_m_s, 30.0);  // ramp shortened to half of 8 s
  EXPECT_DOUBLE_EQ(drive.at(500.0).speed_m_s, 30.0);
}

TEST(Drive, WanderIsAsStrongAsOneSinusoidOfItsAmplitude) {
  const Drive drive(three_speeds(0.2), 3);
  double sum = 0.0;
  const int n = 200'000;
  for (int i = 0; i < n; ++i) sum += std::pow(drive.at(1000.0 + 0.1 * i).speed_m_s - 30.0, 2);
  // 20 000 s hold 500 of the slowest periods, so that the four sinusoids are orthogonal to about 1 %.
  EXPECT_NEAR(std::sqrt(sum / n), 0.2 / std::sqrt(2.0), 0.02 * 0.2);
}

TEST(Drive, DriftsFromItsBeginningToItsEnd) {
  DriveScenario scenario = three_speeds(0.0);
  scenario.drift_m_s2 = 0.1;
  const Drive drive(scenario, 7);
  const Drive steady(three_speeds(0.0), 7);
  EXPECT_DOUBLE_EQ(drive.at(-3.0).speed_m_s, 25.0);
  EXPECT_DOUBLE_EQ(drive.at(30.0).speed_m_s, 25.0 + 3.0);
  EXPECT_DOUBLE_EQ(drive.at(80.0).speed_m_s, 36.0 + 8.0);
  EXPECT_NEAR(drive.at(80.0).position_m, steady.at(80.0).position_m + 0.5 * 0.1 * 80.0 * 80.0, 1e-9);
  EXPECT_DOUBLE_EQ(drive.at(30.0).acceleration_m_s2, 0.1);
  EXPECT_DOUBLE_EQ(drive.at(200.0).speed_m_s, 30.0 + 9.8);
  EXPECT_NEAR(drive.at(200.0).position_m - drive.at(100.0).position_m, 100.0 * 39.8, 1e-9);
}

TEST(Drive, DependsOnTheSeedOnlyInItsWander) {
  EXPECT_EQ(Drive(three_speeds(0.0), 1).at(12.0).position_m, Drive(three_speeds(0.0), 2).at(12.0).position_m);
  EXPECT_NE(Drive(three_speeds(0.1), 1).at(12.0).position_m, Drive(three_speeds(0.1), 2).at(12.0).position_m);
}

}  // namespace
}  // namespace roadbalance::sim
