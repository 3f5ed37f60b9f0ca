// Published balancing cases.  Expected values: complex least squares of the printed inputs, computed by
// another program; what the authors printed is beside them where it differs.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "host/analysis/balance/influence.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
Complex at(double length, double degrees) {
  return std::polar(length, degrees * std::numbers::pi / 180.0);
}

/// To 0.5 % and 0.5 degrees.
void expect_weight(Complex found, double grams, double degrees) {
  EXPECT_NEAR(std::abs(found) / grams, 1.0, 5e-3) << grams << " at " << degrees;
  EXPECT_NEAR(std::remainder(std::arg(found) * 180.0 / std::numbers::pi - degrees, 360.0), 0.0, 0.5);
}

Eigen::VectorXcd weights_of(const Eigen::MatrixXcd& influence, const Eigen::VectorXcd& bare) {
  const auto found = correction_by_influence(influence, bare);
  EXPECT_TRUE(found);
  return found.value_or(Eigen::VectorXcd::Zero(influence.cols()));
}

InfluenceRun run(Eigen::VectorXcd weight, Eigen::VectorXcd observed) {
  InfluenceRun result;
  result.weight = std::move(weight);
  result.variance = Eigen::VectorXd::Constant(observed.size(), 1e-6);
  result.observed = std::move(observed);
  return result;
}

// Brüel & Kjær, Static and Dynamic Balancing (J. Vaughan), static example.
TEST(PublishedCases, BruelKjaerStatic) {
  const auto found = balance_by_influence(
      {run(Eigen::VectorXcd::Zero(1), Eigen::VectorXcd::Constant(1, at(3.4, 116))),
       run(Eigen::VectorXcd::Constant(1, 2.0), Eigen::VectorXcd::Constant(1, at(1.8, 42)))});
  ASSERT_TRUE(found);
  expect_weight(found->correction(0), 2.012, 329.2);
}

// Brüel & Kjær BO 0276 (17-227), example 6, with 185 degrees for the second plane's effect on the first
// bearing (other quotations have 186 or 189); as quoted in hsbalance (MIT).
TEST(PublishedCases, BruelKjaerTwoPlanes) {
  const auto found =
      balance_by_influence({run(Eigen::Vector2cd(0, 0), Eigen::Vector2cd(at(170, 112), at(53, 78))),
                            run(Eigen::Vector2cd(1.15, 0), Eigen::Vector2cd(at(235, 94), at(58, 68))),
                            run(Eigen::Vector2cd(0, 1.15), Eigen::Vector2cd(at(185, 115), at(77, 104)))});
  ASSERT_TRUE(found);
  expect_weight(found->correction(0), 1.979, 236.2);
  expect_weight(found->correction(1), 1.071, 121.8);
}

// T. P. Goodman, J. Engineering for Industry 86 (1964) 273-279; he prints 0.81 and 1.48.
TEST(PublishedCases, Goodman) {
  Eigen::MatrixXcd influence(3, 2);
  influence << 3.0, -2.0, 5.0, -2.0, 5.0, -3.0;
  const Eigen::Vector3cd bare(1.0, -1.0, 0.0);
  const Eigen::VectorXcd found = weights_of(influence, bare);
  expect_weight(found(0), 0.810, 0.0);
  expect_weight(found(1), 1.476, 0.0);
  EXPECT_NEAR((bare + influence * found).norm() / std::sqrt(3.0), 0.3563, 1e-4);
}

// M. S. Darlow, ASME J. Mechanical Design 104 (1982); he prints 1.39 at -4, 1.25 at -144, 0.98 at 168
// degrees, and without the second plane 0.51 at 46 and 1.13 at -155.
TEST(PublishedCases, Darlow) {
  Eigen::MatrixXcd influence(4, 3);
  influence << at(1.41, 45), at(2.24, 27), at(3.61, 34),  //
      at(3.16, 72), at(4.47, 27), at(2.24, 27),           //
      at(2.83, 45), at(2.24, 27), at(5, 37),              //
      at(3.16, 18), at(3.61, 34), at(4.47, 27);
  const Eigen::Vector4cd bare(at(3.16, 72), at(3.16, 18), at(4.12, 14), at(5.39, 68));
  const Eigen::VectorXcd all = weights_of(influence, bare);
  expect_weight(all(0), 1.375, 356.5);
  expect_weight(all(1), 1.227, 215.9);
  expect_weight(all(2), 0.977, 167.7);
  Eigen::MatrixXcd two(4, 2);
  two << influence.col(0), influence.col(2);
  const Eigen::VectorXcd without_second = weights_of(two, bare);
  expect_weight(without_second(0), 0.524, 44.4);
  expect_weight(without_second(1), 1.137, 204.5);
}

// T. Feese and P. Grazier, Balance This!, 33rd Turbomachinery Symposium (2004): the first trial weight stays
// on for the second trial run.  They print 15.3 at 3 and 6.6 at 113 degrees.
TEST(PublishedCases, FeeseGrazierKeepTheTrialWeight) {
  const Eigen::Vector4cd bare(at(.68, 32), at(.56, 86), at(1.94, 231), at(2.07, 335));
  const Eigen::Vector4cd first(at(1.31, 1), at(1.25, 75), at(.93, 251), at(1, 342));
  const Eigen::Vector4cd both(at(.54, 9), at(.52, 75), at(.81, 196), at(.9, 296));
  const auto found =
      balance_by_influence({run(Eigen::Vector2cd(0, 0), bare), run(Eigen::Vector2cd(at(11.1, 35), 0), first),
                            run(Eigen::Vector2cd(at(11.1, 35), at(3.7, 135)), both)});
  ASSERT_TRUE(found);
  expect_weight(found->correction(0), 15.330, 2.9);
  expect_weight(found->correction(1), 6.617, 112.9);
}

}  // namespace
}  // namespace roadbalance
