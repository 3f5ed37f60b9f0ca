#include "common/dsp/decimating_filter.hpp"

#include <gtest/gtest.h>

#include <random>

#include "common/dsp/decimation.hpp"

namespace roadbalance {
namespace {

Eigen::MatrixXd whole_numbers(Eigen::Index rows, Eigen::Index columns) {
  static std::mt19937 random(1);
  std::uniform_int_distribution<int> whole(-1000, 1000);
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return whole(random); });
}

/// With whole numbers every order of summing gives the same.
void expect_sums(DecimatingFilter& filter, int factor, const Eigen::VectorXd& taps, std::int64_t first,
                 Eigen::Index channels) {
  const Eigen::Index n = taps.size();
  const Eigen::MatrixXd samples = whole_numbers(channels, 2 * n + 3 * factor);
  filter.restart(first);
  for (Eigen::Index i = 0; i < samples.cols(); ++i) {
    const bool has_output = filter.add(samples.col(i));
    ASSERT_EQ(has_output, i >= n - 1 && (first + i) % factor == 0) << i << " from " << first;
    if (has_output) {
      EXPECT_EQ(filter.output(), samples.middleCols(i - n + 1, n) * taps) << i << " of " << channels;
    }
  }
}

TEST(DecimatingFilter, GivesEveryFactorthSumOfTapsTimesSamplesFromAnyIndexOn) {
  for (const Eigen::Index channels : {1, 7, 8, 9, 16, 21})
    for (const int factor : {1, 2, 3, 12})
      for (const Eigen::Index count : {1, 2, 3, 5, 16 * factor, 16 * factor + 1}) {
        const Eigen::VectorXd taps = whole_numbers(count, 1);
        DecimatingFilter filter(channels, factor, taps);
        for (const std::int64_t first : {0, 1, factor - 1, -1, -12345, 1000001})
          expect_sums(filter, factor, taps, first, channels);
      }
}

TEST(DecimatingFilter, KnowsNothingOfSamplesBeforeARestart) {
  DecimatingFilter filter(3, 4, decimation_taps(4));
  for (int i = 0; i < 200; ++i) filter.add(Eigen::Vector3d::Constant(1e6));
  filter.restart(2);
  int outputs = 0;
  for (int i = 2; i < 200; ++i)
    if (filter.add(Eigen::Vector3d(1.0, 2.0, -3.0))) {
      EXPECT_TRUE(filter.output().isApprox(Eigen::Vector3d(1.0, 2.0, -3.0), 1e-12));
      ++outputs;
    }
  EXPECT_EQ(outputs, 33);  // 65 taps: at 68, 72 .. 196
}

}  // namespace
}  // namespace roadbalance
