#include "common/dsp/lagged_covariance.hpp"

#include <algorithm>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "common/dsp/state_filter.hpp"
#include "common/test/no_allocation.hpp"

namespace roadbalance {
namespace {

Eigen::MatrixXd white(Eigen::Index rows, Eigen::Index samples, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, samples, [&] { return normal(random); });
}

/// By the definition, one sample and one lag after the other.
Eigen::MatrixXd by_definition(const Eigen::MatrixXd& y, const Eigen::MatrixXd& z, Eigen::Index lags) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(y.rows(), z.rows() * lags);
  for (Eigen::Index t = 0; t < y.cols(); ++t)
    for (Eigen::Index k = 0; k < lags; ++k)
      for (Eigen::Index c = 0; c < z.rows(); ++c) sum.col(k * z.rows() + c) += y.col(t) * z(c, t + k);
  return sum;
}

TEST(LaggedProducts, AreTheDefinitionsForEveryShape) {
  // Every rest that tiles of any width leave, in rows, columns and samples.
  for (Eigen::Index rows = 1; rows <= 37; ++rows)
    for (const Eigen::Index measured : {1, 3, 7, 16})
      for (const Eigen::Index lags : {1, 2, 5})
        for (const Eigen::Index samples : {0, 1, 63, 64, 130}) {
          const Eigen::MatrixXd y = white(rows, samples, 1), z = white(measured, samples + lags - 1, 2);
          Eigen::MatrixXd sum = Eigen::MatrixXd::Ones(rows, measured * lags);
          add_lagged_products(y, z, sum);
          const Eigen::MatrixXd expected =
              by_definition(y, z, lags) + Eigen::MatrixXd::Ones(rows, measured * lags);
          // 130 products of numbers about 1 in another order: some 1e-16 each.
          ASSERT_LT((sum - expected).cwiseAbs().maxCoeff(), 1e-12)
              << rows << " rows, " << measured << " measured, " << lags << " lags, " << samples << " samples";
        }
}

TEST(LaggedProducts, NeverAllocate) {
  const Eigen::MatrixXd y = white(80, 100, 1), z = white(16, 115, 2);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(80, 256);
  const test::NoAllocation guard;
  add_lagged_products(y, z, sum);
}

TEST(LaggedProducts, RefuseShapesThatDoNotFit) {
  const Eigen::MatrixXd y = white(4, 10, 1), z = white(3, 11, 2);
  Eigen::MatrixXd rows(5, 6), columns(4, 7), lags(4, 9);
  EXPECT_THROW(add_lagged_products(y, z, rows), std::invalid_argument);
  EXPECT_THROW(add_lagged_products(y, z, columns), std::invalid_argument);
  EXPECT_THROW(add_lagged_products(y, z, lags), std::invalid_argument);
}

TEST(LaggedCovariance, IsTheSumOfProductsHoweverItIsCut) {
  constexpr Eigen::Index kInputs = 6, kMeasured = 4, kLags = 9, kSamples = 5000, kOrder = 5;
  const DiscreteFilter design = discretise_ramp_invariant(butterworth(kOrder, 30.0), 1.0 / 500.0);
  const Eigen::MatrixXd u = white(kInputs, kSamples, 1), z = white(kMeasured, kSamples + kLags, 2);
  Eigen::MatrixXd y(kInputs * kOrder, kSamples);
  StateFilter filter(design, kInputs);
  for (Eigen::Index t = 0; t < kSamples; ++t) y.col(t) = filter.update(u.col(t).array()).reshaped().matrix();
  // White signals of 1: a sum has about sqrt(samples) = 70, its rounding some 1e-13 of that.
  const Eigen::MatrixXd expected =
      by_definition(y.middleCols(100, kSamples - 101), z.middleCols(100, kSamples - 102 + kLags), kLags);
  for (const Eigen::Index block : {1, 20, 64, 4900}) {
    LaggedCovariance covariance(design, kInputs, kMeasured, kLags);
    for (Eigen::Index from = 100; from < kSamples;
         from += block) {  // not from rest: y(0) is in the end terms
      const Eigen::Index count = std::min(block, kSamples - from);
      covariance.add(u.middleCols(from, count), y.middleCols(from, count),
                     z.middleCols(from, count + kLags - 1));
    }
    EXPECT_LT((covariance.sums() - expected).cwiseAbs().maxCoeff(), 1e-10) << "blocks of " << block;
  }
}

TEST(LaggedCovariance, RefusesShapesThatDoNotFit) {
  LaggedCovariance covariance(discretise_ramp_invariant(butterworth(2, 30.0), 1.0 / 500.0), 2, 3, 4);
  EXPECT_THROW(covariance.add(white(2, 5, 1), white(4, 5, 2), white(3, 5, 3)), std::invalid_argument);
  EXPECT_THROW(covariance.add(white(2, 5, 1), white(3, 5, 2), white(3, 8, 3)), std::invalid_argument);
  EXPECT_NO_THROW(covariance.add(white(2, 5, 1), white(4, 5, 2), white(3, 8, 3)));
}

}  // namespace
}  // namespace roadbalance
