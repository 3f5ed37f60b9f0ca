#include "common/angle/local_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstdint>

namespace roadbalance {
namespace {

constexpr std::int64_t kFirst_ns = 7'000'000'000, kPoint_ns = 700'000;

/// Points of a wheel that turns so, each of as many teeth as given for its place.
WheelPath path_of(std::size_t points, double (*position)(double t_s)) {
  WheelPath path(64);
  for (std::size_t k = 0; k < points; ++k) {
    const auto after_ns = static_cast<std::int64_t>(k) * kPoint_ns;
    path.push({.time_ns = kFirst_ns + after_ns,
               .position = position(1e-9 * static_cast<double>(after_ns)),
               .weight = 1.0 + static_cast<double>(k % 3)});
  }
  return path;
}
double cubic(double t_s) {
  return 1e6 + 1340.0 * t_s + 900.0 * t_s * t_s - 4e4 * t_s * t_s * t_s;
}

// An even number of points and an odd one, whose last has no partner to make a pair with.
class LocalFitOf : public ::testing::TestWithParam<std::size_t> {};

TEST_P(LocalFitOf, ACubicIsExact) {
  const WheelPath path = path_of(GetParam(), cubic);
  LocalFit fit;
  ASSERT_TRUE(fit.fit(path, 0, path.size(), 0.0));
  for (double after_ns = 0.0; after_ns <= static_cast<double>(path.latest().time_ns - kFirst_ns);
       after_ns += 3e5)
    EXPECT_NEAR(fit.position(after_ns), cubic(1e-9 * after_ns), 1e-8);  // of a million: 1e-14
  EXPECT_NEAR(fit.noise(), 0.0, 1e-16);
}

// By the normal equations in powers of time, whose inverse is the covariance of the cubic's coefficients.
TEST_P(LocalFitOf, TheVarianceIsThatOfWeightedLeastSquares) {
  const WheelPath path = path_of(GetParam(), cubic);
  LocalFit fit;
  ASSERT_TRUE(fit.fit(path, 0, path.size(), 0.0));
  const double half_ns = 0.5 * static_cast<double>(path.latest().time_ns - kFirst_ns);
  const auto powers = [&](double after_ns) {
    const double u = after_ns / half_ns - 1.0;
    return Eigen::Vector4d(1.0, u, u * u, u * u * u);
  };
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  for (std::size_t k = 0; k < path.size(); ++k) {
    const Eigen::Vector4d row = powers(static_cast<double>(path[k].time_ns - kFirst_ns));
    normal += path[k].weight * row * row.transpose();
  }
  for (const double after_ns : {0.0, 0.4 * half_ns, half_ns, 1.9 * half_ns}) {
    const double expected = powers(after_ns).dot(normal.ldlt().solve(powers(after_ns)));
    EXPECT_NEAR(fit.variance(after_ns) / expected, 1.0, 1e-9) << after_ns;
  }
}

// For either of a pair, and for the one that is alone.
TEST_P(LocalFitOf, APulseThatWasNoToothDoesNotCount) {
  for (const std::size_t wrong : {std::size_t{4}, std::size_t{5}, GetParam() - 1}) {
    const WheelPath good = path_of(GetParam(), cubic);
    WheelPath path(64);
    for (std::size_t k = 0; k < good.size(); ++k) {
      WheelPoint point = good[k];
      if (k == wrong) point.position += 0.3;
      path.push(point);
    }
    LocalFit fit;
    ASSERT_TRUE(fit.fit(path, 0, path.size(), 0.025 * 0.025));
    EXPECT_NEAR(fit.position(4.5 * kPoint_ns), cubic(4.5e-9 * kPoint_ns), 1e-8) << wrong;
  }
}

INSTANTIATE_TEST_SUITE_P(Points, LocalFitOf, ::testing::Values(20, 21, 33));

TEST(LocalFit, TooFewPointsAreRefused) {
  const WheelPath path = path_of(LocalFit::kLeastPoints, cubic);
  LocalFit fit;
  EXPECT_FALSE(fit.fit(path, 1, path.size(), 0.0));
  EXPECT_TRUE(fit.fit(path, 0, path.size(), 0.0));
}

}  // namespace
}  // namespace roadbalance
