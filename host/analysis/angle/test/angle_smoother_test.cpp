#include "host/analysis/angle/angle_smoother.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr double kRate_hz = 1728.0;

/// A tooth every 1/kRate_hz s on `path`, pitches of seconds, with noise.
std::vector<WheelPoint> points(const std::function<double(double)>& path, double sigma, double seconds) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, sigma);
  std::vector<WheelPoint> all;
  for (int i = 0; i < seconds * kRate_hz; ++i)
    all.push_back({std::llround(i / kRate_hz * 1e9), path(i / kRate_hz) + normal(random), 1.0});
  return all;
}

double rms(const AngleSmoother& smoother, const std::function<double(double)>& path, double seconds) {
  double square = 0.0;
  int count = 0;
  for (double t = 0.2; t < seconds - 0.2; t += 0.0007, ++count)
    square += std::pow(smoother.position(std::llround(t * 1e9)) - path(t), 2);
  return std::sqrt(square / count);
}

const auto kSteady = [](double t) { return kRate_hz * t + 3.0 * t * t; };
const auto kTorsion = [](double t) { return kSteady(t) + 0.27 * std::sin(2.0 * pi * 13.0 * t); };

TEST(AngleSmoother, AveragesJitterWhereTheWheelRunsSmoothly) {
  AngleSmoother smoother;
  ASSERT_TRUE(smoother.smooth(points(kSteady, 0.1, 6.0), 0.01));
  EXPECT_LE(smoother.bandwidth_hz(), 6.0);
  // White noise through 1 / (1 + (f / fc)^6): its variance times 2 fc 5/6 (pi/6) / sin(pi/6) / rate.
  const double expected = 0.1 * std::sqrt(2.0 * smoother.bandwidth_hz() * 0.873 / kRate_hz);
  EXPECT_LT(rms(smoother, kSteady, 6.0), 1.5 * expected);
  EXPECT_NEAR(smoother.sigma(3'000'000'000), expected, 0.15 * expected);
}

TEST(AngleSmoother, FollowsTorsionalMotionAtWheelHop) {
  AngleSmoother smoother;
  ASSERT_TRUE(smoother.smooth(points(kTorsion, 0.02, 6.0), 0.0004));
  EXPECT_GE(smoother.bandwidth_hz(), 18.0);
  // A twentieth of the motion's rms.
  EXPECT_LT(rms(smoother, kTorsion, 6.0), 0.05 * 0.27 / std::sqrt(2.0));
}

TEST(AngleSmoother, PassesOverPulsesThatWereNoTeeth) {
  auto with_strangers = points(kTorsion, 0.02, 6.0);
  AngleSmoother smoother;
  ASSERT_TRUE(smoother.smooth(with_strangers, 0.0004));
  const double without = rms(smoother, kTorsion, 6.0);
  for (std::size_t i = 50; i < with_strangers.size(); i += 100) with_strangers[i].position += 0.4;
  ASSERT_TRUE(smoother.smooth(with_strangers, 0.0004));
  EXPECT_LT(rms(smoother, kTorsion, 6.0), 1.1 * without);
}

TEST(AngleSmoother, RefusesWhatTellsNoMotion) {
  AngleSmoother smoother;
  EXPECT_FALSE(smoother.smooth({}, 0.01));
  EXPECT_FALSE(smoother.smooth(points(kSteady, 0.0, 0.002), 0.01));
  EXPECT_FALSE(smoother.smooth(points([](double) { return 5.0; }, 0.0, 1.0), 0.01));
  EXPECT_FALSE(smoother.smooth(points(kSteady, 0.1, 1.0), 0.0));
}

}  // namespace
}  // namespace roadbalance
