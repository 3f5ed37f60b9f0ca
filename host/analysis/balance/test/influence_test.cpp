#include "host/analysis/balance/influence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <stdexcept>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr double kDegree = std::numbers::pi / 180.0;
Complex at(double length, double degrees) {
  return std::polar(length, degrees * kDegree);
}

InfluenceRun run(std::vector<Complex> weight, std::vector<Complex> observed, double variance = 1e-4) {
  InfluenceRun r;
  r.weight = Eigen::Map<Eigen::VectorXcd>(weight.data(), std::ssize(weight));
  r.observed = Eigen::Map<Eigen::VectorXcd>(observed.data(), std::ssize(observed));
  r.variance = Eigen::VectorXd::Constant(std::ssize(observed), variance);
  return r;
}

/// The two-plane example of S. S. Rao, Mechanical Vibrations, chapter 9; the numbers here by Cramer's rule in
/// a script of its own.  Rao gives 10.0561 and 5.8774.
TEST(BalanceByInfluence, SolvesTheTwoPlaneExampleOfTheBook) {
  const auto balance = balance_by_influence({run({0.0, 0.0}, {at(8.5, 60), at(6.5, 205)}),
                                             run({at(10, 270), 0.0}, {at(6, 125), at(4.5, 230)}),
                                             run({0.0, at(12, 180)}, {at(6, 35), at(10.5, 160)})});
  ASSERT_TRUE(balance);
  EXPECT_LT(std::abs(balance->correction(0) - at(10.056139, 325.554804)), 1e-5);
  EXPECT_LT(std::abs(balance->correction(1) - at(5.877362, 68.255934)), 1e-5);
  EXPECT_LT(std::abs(balance->influence(0, 0) - Complex(0.244630366643378, -0.7691458618106277)), 1e-9);
  EXPECT_LT(std::abs(balance->influence(1, 1) - Complex(0.3313143252094845, -0.5281858505195057)), 1e-9);
  EXPECT_LT(balance->residual.cwiseAbs().maxCoeff(), 1e-9) << "two weights, two channels: nothing is left";
}

/// More channels than planes: Goodman's normal equations, solved in a script of its own.
TEST(BalanceByInfluence, LeavesTheLeastSquaresWhereThereAreMoreChannelsThanPlanes) {
  const Complex i(0.0, 1.0);
  Eigen::MatrixXcd influence(3, 2);
  influence << 1.0 + 2.0 * i, 0.5 - 0.3 * i, 0.2 * i, 2.0 - 1.0 * i, 1.5, -1.0 + 0.5 * i;
  const Eigen::Vector3cd bare(3.0 - 1.0 * i, 0.5 + 2.0 * i, -1.0 + 1.0 * i);
  // Weights that stay on, and one run more than needed.
  std::vector<InfluenceRun> runs;
  for (const auto& [a, b] : {std::pair<Complex, Complex>{0.0, 0.0}, {2.0, 0.0}, {2.0, 1.0 + i}, {0.0, -i}}) {
    InfluenceRun r;
    r.weight = Eigen::Vector2cd(a, b);
    r.observed = bare + influence * r.weight;
    r.variance = Eigen::Vector3d::Constant(1e-4);
    runs.push_back(r);
  }
  const auto balance = balance_by_influence(runs);
  ASSERT_TRUE(balance);
  EXPECT_LT((balance->influence - influence).norm(), 1e-9);
  EXPECT_LT(std::abs(balance->correction(0) - Complex(0.01592305904971918, 0.6104750493192014)), 1e-9);
  EXPECT_LT(std::abs(balance->correction(1) - Complex(-0.25665966568409926, -0.5032278933724538)), 1e-9);
  EXPECT_LT(std::abs(balance->residual(2) - Complex(-0.46784179905509504, 2.2906106345077064)), 1e-9);
  EXPECT_NEAR(balance->rms_before, bare.norm() / std::sqrt(3.0), 1e-9);
  EXPECT_LT(balance->rms_after, balance->rms_before);
}

TEST(BalanceByInfluence, ChecksRunsByOneAnother) {
  const Complex bare = at(2.0, 40), influence = at(0.5, -70);
  std::mt19937 random(11);
  const double sigma = 0.02;
  std::normal_distribution<double> part(0.0, sigma / std::sqrt(2.0));
  const auto runs = [&](double wrong) {
    std::vector<InfluenceRun> all;
    for (const Complex& weight : {Complex(0.0), Complex(3.0), at(3.0, 120), at(3.0, 240)})
      all.push_back(
          run({weight}, {bare + influence * weight + Complex(part(random), part(random))}, sigma * sigma));
    all.back().observed(0) += wrong;
    return all;
  };
  constexpr int kDraws = 4000;
  int rare = 0;
  for (int k = 0; k < kDraws; ++k) rare += balance_by_influence(runs(0.0))->chance < 0.05;
  EXPECT_NEAR(static_cast<double>(rare) / kDraws, 0.05, 4.0 * std::sqrt(0.05 * 0.95 / kDraws));
  EXPECT_LT(balance_by_influence(runs(0.3))->chance, 1e-6) << "a weight was not where it was said to be";
  auto enough = runs(0.0);
  enough.resize(2);
  EXPECT_EQ(balance_by_influence(enough)->chance, 1.0) << "nothing checks them";
}

TEST(BalanceByInfluence, KnowsItsUncertainty) {
  // One plane, one channel: w = -t e0 / (e1 - e0).
  const Complex bare = at(2.0, 40), influence = at(0.5, -70), trial = 3.0;
  const double sigma = 0.02;  // of both parts together
  const auto balance = balance_by_influence(
      {run({0.0}, {bare}, sigma * sigma), run({trial}, {bare + influence * trial}, sigma * sigma)});
  ASSERT_TRUE(balance);
  EXPECT_LT(std::abs(balance->correction(0) + bare / influence), 1e-9);
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, sigma / std::sqrt(2.0));
  double square = 0.0;
  constexpr int kDraws = 4000;
  for (int k = 0; k < kDraws; ++k) {
    const Complex e0 = bare + Complex(normal(random), normal(random));
    const Complex e1 = bare + influence * trial + Complex(normal(random), normal(random));
    square += 0.5 * std::norm(-trial * e0 / (e1 - e0) + bare / influence) / kDraws;
  }
  EXPECT_NEAR(balance->sigma(0) / std::sqrt(square), 1.0, 0.06);  // 4000 draws: 1 %, and second order
}

TEST(BalanceByInfluence, KnowsWhatAPhaseReferenceCostsThatIsOffInAWholeRun) {
  // Two channels and one plane, so that both kinds of uncertainty are in both sums; drawn by its solution.
  const Eigen::Vector2cd bare(at(2.0, 40), at(1.0, 170)), influence(at(0.5, -70), at(0.3, 20));
  const Complex trial = 3.0;
  constexpr double kSigma_rad = 0.03, kSigma = 0.02;
  std::vector<InfluenceRun> runs;
  for (const Complex& weight : {Complex(0.0), trial}) {
    runs.push_back(
        run({weight}, {bare(0) + influence(0) * weight, bare(1) + influence(1) * weight}, kSigma * kSigma));
    runs.back().phase_sigma_rad = kSigma_rad;
  }
  const auto balance = balance_by_influence(runs);
  ASSERT_TRUE(balance);
  const Complex exact = -influence.dot(bare) / influence.squaredNorm();
  EXPECT_LT(std::abs(balance->correction(0) - exact), 1e-9);
  std::mt19937 random(5);
  std::normal_distribution<double> part(0.0, kSigma / std::sqrt(2.0)), phase(0.0, kSigma_rad);
  double square = 0.0;
  constexpr int kDraws = 20'000;
  for (int k = 0; k < kDraws; ++k) {
    Eigen::Vector2cd drawn[2];
    for (std::size_t r = 0; r < 2; ++r) {
      drawn[r] = runs[r].observed * std::polar(1.0, phase(random));
      for (Complex& value : drawn[r]) value += Complex(part(random), part(random));
    }
    const Eigen::Vector2cd a = (drawn[1] - drawn[0]) / trial;
    square += 0.5 * std::norm(-a.dot(drawn[0]) / a.squaredNorm() - exact) / kDraws;
  }
  EXPECT_NEAR(balance->sigma(0) / std::sqrt(square), 1.0, 0.03);  // 20000 draws: 0.5 %, and second order
}

TEST(BalanceByInfluence, RefusesRunsThatDoNotTellTheInfluences) {
  EXPECT_FALSE(balance_by_influence({run({0.0}, {1.0})}));
  EXPECT_FALSE(balance_by_influence({run({0.0, 0.0}, {1.0, 2.0}), run({1.0, 0.0}, {2.0, 2.0})}))
      << "nothing in the second plane";
  EXPECT_FALSE(balance_by_influence({run({1.0}, {1.0}), run({1.0}, {2.0})})) << "the same weight twice";
  EXPECT_FALSE(balance_by_influence(
      {run({0.0, 0.0}, {1.0, 1.0}), run({1.0, 0.0}, {2.0, 2.0}), run({0.0, 1.0}, {2.0, 2.0})}))
      << "both planes do the same to what is observed";
  // Scatter alone, in eight channels: it is no influence.
  std::mt19937 random(9);
  std::normal_distribution<double> part(0.0, 1e-2 / std::sqrt(2.0));
  std::vector<InfluenceRun> nothing;
  for (const double weight : {0.0, 5.0}) {
    std::vector<Complex> seen;
    for (int k = 0; k < 8; ++k) seen.push_back(at(1.0, 40.0 * k) + Complex(part(random), part(random)));
    nothing.push_back(run({weight}, seen));
  }
  EXPECT_FALSE(balance_by_influence(nothing)) << "the weight did nothing";
  for (Eigen::Index k = 0; k < 8; ++k) nothing[1].observed(k) += 0.05;
  EXPECT_TRUE(balance_by_influence(nothing)) << "five times the scatter";
  EXPECT_THROW(balance_by_influence({}), std::invalid_argument);
  EXPECT_THROW(balance_by_influence({run({0.0}, {1.0}), run({1.0, 0.0}, {1.0})}), std::invalid_argument);
  EXPECT_THROW(balance_by_influence({run({0.0}, {1.0}, 0.0)}), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
