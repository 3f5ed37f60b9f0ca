#include "common/dsp/state_filter.hpp"

#include <random>

#include <gtest/gtest.h>

#include "common/test/no_allocation.hpp"

namespace roadbalance {
namespace {

constexpr int kChannelCount = 7;

DiscreteFilter filter() {
  return discretise_ramp_invariant(butterworth(6, 200.0), 1.0 / 2'000.0);
}

Eigen::ArrayXd noise(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::ArrayXd u(kChannelCount);
  for (double& value : u) value = normal(random);
  return u;
}

TEST(StateFilter, EqualsTheMatrixRecursionOfEachChannel) {
  const DiscreteFilter f = filter();
  StateFilter bank(f, kChannelCount);
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(f.b0.size(), kChannelCount);  // [state x channel]
  Eigen::RowVectorXd last = Eigen::RowVectorXd::Zero(kChannelCount);
  std::mt19937 random(3);
  for (int k = 0; k < 500; ++k) {
    const Eigen::ArrayXd u = noise(random);
    x = (f.A * x + f.b0 * last + f.b1 * u.matrix().transpose()).eval();
    last = u.matrix().transpose();
    // The recursion is stable, so that rounding of the other order of sums stays near 1e-16 of the states.
    ASSERT_LT((bank.update(u).matrix().transpose() - x).cwiseAbs().maxCoeff(), 1e-13) << k;
  }
}

TEST(StateFilter, HoldsAConstantAtGainOne) {
  StateFilter bank(filter(), kChannelCount);
  const Eigen::ArrayXd u = Eigen::ArrayXd::LinSpaced(kChannelCount, -3.0, 3.0);
  for (int k = 0; k < 400; ++k) bank.update(u);  // 0.2 s, 40 times the slowest pole's time constant
  EXPECT_LT((bank.states().col(0) - u).abs().maxCoeff(), 1e-12);
  EXPECT_LT(bank.states().rightCols(5).abs().maxCoeff(), 1e-12);
}

TEST(StateFilter, StartsAgainFromRestBitForBit) {
  StateFilter bank(filter(), kChannelCount);
  StateFilter fresh(filter(), kChannelCount);
  std::mt19937 random(4);
  for (int k = 0; k < 50; ++k) bank.update(noise(random));
  bank.reset();
  for (int k = 0; k < 50; ++k) {
    const Eigen::ArrayXd u = noise(random);
    bank.update(u);
    fresh.update(u);
    ASSERT_TRUE((bank.states() == fresh.states()).all()) << k;
  }
}

TEST(StateFilter, NeverAllocates) {
  StateFilter bank(filter(), kChannelCount);
  const Eigen::ArrayXd u = Eigen::ArrayXd::Ones(kChannelCount);
  const test::NoAllocation guard;
  for (int k = 0; k < 100; ++k) bank.update(u);
}

}  // namespace
}  // namespace roadbalance
