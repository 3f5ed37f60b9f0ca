#include "host/analysis/balance/overall.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
Complex at(double length, double degrees) {
  return std::polar(length, degrees * std::numbers::pi / 180.0);
}

/// Wheel accelerations of two independent quarter cars at some speeds: what their tyres' and unbalances'
/// forces do, per unit (w^2 M^-1 at the wheel).
struct TwoWheels {
  Complex unbalance[2], force[2];
  std::vector<ResponsePoint> points(const std::vector<double>& km_h) const {
    std::vector<ResponsePoint> all;
    for (const double speed : km_h) {
      const double omega = speed / 3.6 / 0.30;
      for (int p = 0; p < 2; ++p) {
        const Complex response =
            -omega * omega / (237e3 + Complex(0.0, 1500.0 * omega) - 34.0 * omega * omega);
        ResponsePoint point{0.0, Eigen::VectorXcd::Zero(2), Eigen::VectorXd::Constant(2, omega), 1.0};
        point.per_force(p) = response;
        point.measured = response * (unbalance[p] * omega * omega + force[p]);
        all.push_back(point);
      }
    }
    return all;
  }
};
// 30 g at 40 degrees and 20 g at -97 degrees at 0.19 m.
const TwoWheels kOut{{at(0.0057, 40.0), at(0.0038, -97.0)}, {0.0, 0.0}};

TEST(OverallCompensation, IsTheOppositeWeightIfThereIsNoOtherCause) {
  const auto found = compensate_overall(kOut.points({110, 120, 130}));
  ASSERT_TRUE(found);
  for (int w = 0; w < 2; ++w) EXPECT_LT(std::abs(found->correction_kg_m(w) + kOut.unbalance[w]), 1e-12);
  EXPECT_LT(found->rms_after, 1e-12);
}

/// With forces of 25 and 15 N that do not grow with speed the opposite weight leaves what they do; the best
/// weights take their mean share.  By hand for one wheel, with g = |H|^2 and sums over the speeds:
/// x = -(U + R sum g Om^2 / sum g Om^4), and what is left of R alone is sqrt(1 - r^2) of it, r the
/// correlation of Om^2 with 1 under g.
TEST(OverallCompensation, TakesWhatForcesHaveInCommonOverTheSpeeds) {
  TwoWheels car = kOut;
  car.force[0] = at(25.0, 117.0);
  car.force[1] = at(15.0, -20.0);
  const std::vector<double> speeds{80, 97, 113, 130};
  const auto points = car.points(speeds);
  const auto found = compensate_overall(points);
  ASSERT_TRUE(found);
  double g0 = 0.0, g2 = 0.0, g4 = 0.0;
  for (const ResponsePoint& point : points) {
    const double g = std::norm(point.per_force(0)), om2 = point.omega(0) * point.omega(0);
    g0 += g, g2 += g * om2, g4 += g * om2 * om2;
  }
  double opposite = 0.0, before = 0.0;
  for (int w = 0; w < 2; ++w) {
    const Complex expected = -(car.unbalance[w] + car.force[w] * (g2 / g4));
    EXPECT_LT(std::abs(found->correction_kg_m(w) - expected), 1e-12);
    opposite += g0 * std::norm(car.force[w]) / static_cast<double>(points.size());
  }
  for (const ResponsePoint& point : points)
    before += std::norm(point.measured) / static_cast<double>(points.size());
  EXPECT_NEAR(found->rms_before, std::sqrt(before), 1e-12);
  const double left = std::sqrt(opposite * (1.0 - g2 * g2 / (g4 * g0)));
  EXPECT_NEAR(found->rms_after, left, 1e-12);
  // The share that the sheet's example has: 0.28 of 0.84.
  EXPECT_NEAR(left / std::sqrt(opposite), 0.33, 0.04);
  // The predicted residual is the residual.
  for (std::size_t p = 0; p < points.size(); ++p) {
    const auto w = static_cast<Eigen::Index>(p % 2);
    const double om2 = points[p].omega(0) * points[p].omega(0);
    EXPECT_LT(std::abs(found->residual(static_cast<Eigen::Index>(p)) - points[p].measured -
                       points[p].per_force(w) * om2 * found->correction_kg_m(w)),
              1e-12);
  }
}

TEST(OverallCompensation, HeedsTheWeightsOfSpeedsAndPlaces) {
  TwoWheels car = kOut;
  car.force[0] = at(25.0, 117.0);
  auto points = car.points({80, 130});
  for (std::size_t p = 0; p < 2; ++p) points[p].weight = 1e9;  // at 80 km/h it shall be still
  const auto found = compensate_overall(points);
  ASSERT_TRUE(found);
  EXPECT_LT(std::abs(found->residual(0)), 1e-6);
  EXPECT_GT(std::abs(found->residual(2)), 0.1);
}

TEST(OverallCompensation, RefusesWhatDoesNotTellTheWeights) {
  EXPECT_FALSE(compensate_overall({}));
  auto points = kOut.points({120});
  points[1].per_force = points[0].per_force;
  EXPECT_FALSE(compensate_overall(points)) << "nothing shows the second wheel";
  points[1].weight = 0.0;
  EXPECT_THROW(compensate_overall(points), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
