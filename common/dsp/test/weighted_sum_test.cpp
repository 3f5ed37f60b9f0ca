#include "common/dsp/weighted_sum.hpp"

#include <gtest/gtest.h>

#include <random>

namespace roadbalance {
namespace {

// With whole numbers every order of summing gives the same.
TEST(WeightedSum, EqualsTheProductAndWritesNothingElse) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> whole(-1000, 1000);
  for (Eigen::Index rows = 1; rows < 20; ++rows)
    for (const Eigen::Index weights : {0, 1, 3, 4, 7, 32, 33}) {
      Eigen::MatrixXd more(rows + 3, weights);  // columns stand apart
      Eigen::VectorXd weight(weights), sum = Eigen::VectorXd::Constant(rows + 2, 0.5);
      for (double& value : more.reshaped()) value = whole(random);
      for (double& value : weight) value = whole(random);
      weighted_sum(more.middleRows(2, rows), weight, sum.segment(1, rows));
      for (Eigen::Index r = 0; r < rows; ++r) {
        double expected = 0.0;
        for (Eigen::Index k = 0; k < weights; ++k) expected += weight(k) * more(2 + r, k);
        EXPECT_EQ(sum(1 + r), expected) << r << " of " << rows << ", " << weights;
      }
      EXPECT_EQ(sum(0), 0.5);
      EXPECT_EQ(sum(rows + 1), 0.5);
    }
}

// Fused, a product and a sum are rounded once, and only processors that can do so would.
TEST(WeightedSum, RoundsEachProductAndEachSum) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> real(-1.0, 1.0);
  Eigen::MatrixXd columns(64, 2);
  Eigen::VectorXd weight(2), sum(64);
  for (double& value : columns.reshaped()) value = real(random);
  for (double& value : weight) value = real(random);
  weighted_sum(columns, weight, sum);
  for (Eigen::Index r = 0; r < columns.rows(); ++r) {
    const volatile double one = weight(0) * columns(r, 0), other = weight(1) * columns(r, 1);
    EXPECT_EQ(sum(r), one + other) << r;
  }
}

}  // namespace
}  // namespace roadbalance
