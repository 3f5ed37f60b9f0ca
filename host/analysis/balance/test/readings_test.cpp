#include "host/analysis/balance/readings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
Complex at(double length, double degrees) {
  return std::polar(length, degrees * std::numbers::pi / 180.0);
}

Readings one_plane() {
  return {.plane = {"hub"}, .channel = {"front"}, .run = {}};
}
Readings::Run run(const std::string& name, Complex weight, Complex seen, std::optional<double> speed = {},
                  double digits_variance = 1e-6, std::optional<double> sigma = {}) {
  return {name, speed, {weight}, {{seen, digits_variance, sigma}}};
}

/// Bruel & Kjaer, Static and Dynamic Balancing (J. Vaughan), static example: 2.012 at 329.2 by the exact
/// solution of its numbers.
TEST(Readings, BalanceByWhatIsWrittenDown) {
  Readings readings = one_plane();
  const double variance = 0.01 * 0.01;
  const Complex b = at(3.4, 116), s = at(1.8, 42);
  readings.run = {run("bare", 0.0, b, {}, variance), run("trial", 2.0, s, {}, variance)};
  const ReadingsBalance found = balance_readings(readings);
  ASSERT_EQ(found.refusal, "");
  EXPECT_NEAR(found.plane[0].mass_g, 2.012, 0.0005);
  EXPECT_NEAR(found.plane[0].angle_rad * 180.0 / std::numbers::pi, 329.2, 0.05);
  // w = -t b / (s - b); both parts of b and s together have the variance.
  const double by_bare = std::abs(2.0 * s / std::pow(s - b, 2)),
               by_trial = std::abs(2.0 * b / std::pow(s - b, 2));
  EXPECT_NEAR(found.plane[0].mass_sigma_g, 0.01 * std::sqrt(0.5) * std::hypot(by_bare, by_trial), 1e-9);
  ASSERT_EQ(found.remark.size(), 1U) << "nothing but the digits says how well they are known";
  EXPECT_NE(found.remark[0].find("digits"), std::string::npos);
  EXPECT_EQ(found.balance.condition, 1.0);
  EXPECT_TRUE(found.rms_without.empty());
  EXPECT_FALSE(found.speed);
}

TEST(Readings, TheScatterOfRepeatedRunsIsTheUncertainty) {
  const Complex bare = at(100.0, 20), influence = at(20.0, 200), trial = 3.0, truth = -bare / influence;
  std::mt19937 random(7);
  std::normal_distribution<double> part(0.0, 1.0);
  const auto seen = [&](Complex weight) {
    return bare + influence * weight + Complex(part(random), part(random));
  };
  constexpr int kDraws = 4000;
  for (const int repeated : {2, 4}) {
    int within = 0;
    for (int k = 0; k < kDraws; ++k) {
      Readings readings = one_plane();
      for (int r = 0; r < repeated; ++r)
        readings.run.push_back(run("bare " + std::to_string(r), 0.0, seen(0.0)));
      readings.run.push_back(run("trial", trial, seen(trial)));
      const ReadingsBalance found = balance_readings(readings);
      ASSERT_EQ(found.refusal, "");
      EXPECT_EQ(found.beyond, repeated - 1);
      EXPECT_TRUE(found.remark.empty());
      const Complex off = found.balance.correction(0) - truth;
      for (const double one : {off.real(), off.imag()}) within += std::abs(one) < found.plane[0].mass_sigma_g;
    }
    // 68.3 %: both parts are of one scatter, so 4000 draws leave 0.7 %; Student's factor 1 %, second order 1
    // %.
    EXPECT_NEAR(within / (2.0 * kDraws), 0.683, 0.025) << repeated;
  }
}

TEST(Readings, ARunWithFewerDigitsCountsAsMuch) {
  Readings readings = one_plane();
  readings.run = {run("first", 0.0, 10.0, {}, 1e-8), run("again", 0.0, 11.0, {}, 1e-2),
                  run("trial", 1.0, 5.0, {}, 1e-2)};
  const ReadingsBalance found = balance_readings(readings);
  ASSERT_EQ(found.refusal, "");
  EXPECT_NEAR(std::abs(found.balance.bare(0) - 10.5), 0.0, 1e-9);
}

TEST(Readings, RunsOfAnotherSpeedAreNamedAndLeftOut) {
  Readings readings = one_plane();
  readings.run = {run("far", 0.0, at(9.0, 100), 58.0),       run("bare", 0.0, at(3.4, 116), 49.0),
                  run("trial", 2.0, at(1.8, 42), 49.4),      run("slow", 0.0, at(5.0, 10), 40.0),
                  run("slow trial", 1.0, at(2.0, 50), 40.1), run("again", 0.0, at(3.41, 116), 49.1)};
  const ReadingsBalance found = balance_readings(readings);
  ASSERT_EQ(found.refusal, "");
  EXPECT_EQ(found.used, (std::vector<std::string>{"bare", "trial", "again"}));
  ASSERT_EQ(found.other_speed.size(), 3U);
  EXPECT_EQ(found.other_speed[0].run, "far");
  EXPECT_EQ(found.other_speed[0].speed, 58.0);
  EXPECT_EQ(found.other_speed[1].run, "slow");
  EXPECT_EQ(found.other_speed[2].run, "slow trial");
  EXPECT_NEAR(*found.speed, (49.0 + 49.4 + 49.1) / 3.0, 1e-9);

  const ReadingsBalance slow = balance_readings(readings, 41.0);
  ASSERT_EQ(slow.refusal, "");
  EXPECT_EQ(slow.used, (std::vector<std::string>{"slow", "slow trial"}));
  const Complex expected = -at(5.0, 10) / (at(2.0, 50) - at(5.0, 10));
  EXPECT_NEAR(std::abs(slow.balance.correction(0) - expected), 0.0, 1e-9);

  const ReadingsBalance alone = balance_readings(readings, 60.0);
  EXPECT_EQ(alone.used, (std::vector<std::string>{"far"}));
  EXPECT_NE(alone.refusal.find("at the same speed"), std::string::npos);
}

/// Two planes whose influence has the singular values 1 and 1 / condition, seen in three channels.
Readings two_planes(double condition, const Eigen::Vector3cd& bare, double sigma) {
  const double turn = 0.6, side = 1.1;
  Eigen::Matrix<Complex, 3, 2> left;
  left << std::cos(side), std::polar(std::sin(side), 0.3), std::polar(std::sin(side), 0.9),
      -std::polar(std::cos(side), 1.2), 0.0, 0.0;
  Eigen::Matrix2cd right;
  right << std::cos(turn), std::sin(turn), -std::sin(turn), std::cos(turn);
  const Eigen::Matrix<Complex, 3, 2> influence =
      left * Eigen::Vector2d(1.0, 1.0 / condition).asDiagonal() * right;
  Readings readings{.plane = {"left", "right"}, .channel = {"a", "b", "c"}, .run = {}};
  for (const Eigen::Vector2cd& weight :
       {Eigen::Vector2cd(0, 0), Eigen::Vector2cd(2, 0), Eigen::Vector2cd(0, 2)}) {
    const Eigen::Vector3cd seen = bare + influence * weight;
    Readings::Run one{std::to_string(readings.run.size()), {}, {weight(0), weight(1)}, {}};
    for (const Complex& value : seen) one.reading.push_back({value, 1e-8, sigma});
    readings.run.push_back(one);
  }
  return readings;
}

TEST(Readings, SaysWhenThePlanesActAlike) {
  const Eigen::Vector3cd bare(at(1.0, 30), at(0.4, 200), at(0.1, 80));
  const ReadingsBalance alike = balance_readings(two_planes(23.8, bare, 1e-3));
  ASSERT_EQ(alike.refusal, "");
  EXPECT_NEAR(alike.balance.condition, 23.8, 1e-6);
  ASSERT_EQ(alike.remark.size(), 1U);
  EXPECT_NE(alike.remark[0].find("condition number 23.8"), std::string::npos);
  const ReadingsBalance different = balance_readings(two_planes(5.0, bare, 1e-3));
  EXPECT_NEAR(different.balance.condition, 5.0, 1e-6);
  EXPECT_TRUE(different.remark.empty());
  // The weak direction's sigma goes with the condition.
  EXPECT_GT(alike.plane[0].mass_sigma_g, 3.0 * different.plane[0].mass_sigma_g);

  // One plane alone leaves |b|^2 - |a* b|^2 / |a|^2.
  ASSERT_EQ(alike.rms_without.size(), 2U);
  for (Eigen::Index p = 0; p < 2; ++p) {
    const Eigen::VectorXcd other = alike.balance.influence.col(1 - p);
    const double left = bare.squaredNorm() - std::norm(other.dot(bare)) / other.squaredNorm();
    EXPECT_NEAR(alike.rms_without[static_cast<std::size_t>(p)], std::sqrt(left / 3.0), 1e-6);
  }
}

TEST(Readings, RunsThatContradictTheirSigmasAreReported) {
  Readings readings = one_plane();
  readings.run = {run("bare", 0.0, 10.0, {}, 1e-6, 0.1), run("again", 0.0, 12.0, {}, 1e-6, 0.1),
                  run("trial", 1.0, 5.0, {}, 1e-6, 0.1)};
  const ReadingsBalance found = balance_readings(readings);
  ASSERT_EQ(found.remark.size(), 1U);
  EXPECT_NE(found.remark[0].find("contradict"), std::string::npos);
  readings.run[1].reading[0].vector = 10.1;
  EXPECT_TRUE(balance_readings(readings).remark.empty());
}

TEST(Readings, RefusesWhatDoesNotTellTheInfluence) {
  EXPECT_NE(balance_readings(one_plane()).refusal, "");
  Readings readings = one_plane();
  readings.run = {run("bare", 0.0, 10.0), run("again", 0.0, 10.1)};
  EXPECT_NE(balance_readings(readings).refusal.find("trial weight"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
