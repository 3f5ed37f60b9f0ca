// The identification relation (2) against exact covariances: Lyapunov's equation for the road, phasors for
// the unbalance.  Nothing here is estimated.
#include <gtest/gtest.h>

#include <cmath>

#include "host/analysis/identify/estimate.hpp"
#include "tools/study/exact_covariance.hpp"

namespace roadbalance::test {
namespace {

/// The car of the derivation; its places and values are those of the published tables.
const Geometry kGeometry{{1.25, 1.25, -1.45, -1.45}, {0.74, -0.74, 0.74, -0.74}};
ParameterVector car() {
  ParameterVector p;
  p << 1300, 480, 2200, 34, 34, 32, 32, 22000, 21000, 24000, 25000, 1500, 1400, 1600, 1700, 12000, 5000,
      215000, 205000, 210000, 220000, 0, 0, 0, 0;
  return p;
}
const std::array<std::complex<double>, kWheels> kUnbalance{
    std::polar(0.035 * 0.19, 3.79), std::polar(0.02 * 0.19, 1.05), std::polar(0.012 * 0.19, -0.4),
    std::polar(0.015 * 0.19, 2.2)};
constexpr double kRadius = 0.30;
constexpr double kClassA = 16e-6;

ExactDrive drive(double speed_km_h, int order = 5, double corner_hz = 30.0) {
  return ExactDrive(kGeometry, car(), kUnbalance, speed_km_h / 3.6, kRadius, kClassA,
                    butterworth(order, corner_hz), corner_hz);
}

/// Residual of (2), worst over its rows: norm over all coordinates and instruments, each divided by its rms,
/// relative to the norm of the row's largest term.
double residual(const ExactDrive& exact, int instruments, double lag_s, double sign_of_q) {
  const LinearModel model = linear_model(kGeometry, car());
  Eigen::Matrix<double, kCoordinates, 5> squares = decltype(squares)::Zero();  // residual and the four terms
  for (int c = 0; c < kCoordinates; ++c)
    for (int j = 0; j < instruments; ++j) {
      const auto m = exact.moments(c, j, lag_s);
      const auto road = exact.with_road(c, j, lag_s);
      const auto force = exact.with_unbalance_force(c, j, lag_s);
      for (int row = 0; row < kCoordinates; ++row) {
        const double mass = m.w2 * model.M.row(row).transpose();
        const double damping = m.w1 * model.P.row(row).transpose();
        const double stiffness = m.w0 * model.Q.row(row).transpose();
        const double outside =
            (road * model.S.row(row).transpose() + force * model.W.row(row).transpose()).value();
        const double sum =
            sign_of_q > 0 ? m.force(model, row) - outside : mass - damping - stiffness - outside;
        const Eigen::Matrix<double, 1, 5> terms(sum, mass, damping, stiffness, outside);
        squares.row(row) += terms.cwiseAbs2() / exact.power(c, j);
      }
    }
  return (squares.col(0).array() / squares.rightCols<4>().rowwise().maxCoeff().array()).sqrt().maxCoeff();
}

TEST(Relation, HoldsForExactCovariancesAtEveryPositiveLag) {
  const ExactDrive exact = drive(120.0);
  for (const double lag_s : {0.0, 0.004, 0.020, 0.100})
    EXPECT_LT(residual(exact, 3, lag_s, +1.0), 1e-10) << lag_s;
}

TEST(Relation, HoldsForOtherOrdersAndCorners) {
  EXPECT_LT(residual(drive(90.0, 3, 20.0), 1, 0.004, +1.0), 1e-10);
  EXPECT_LT(residual(drive(90.0, 8, 60.0), 6, 0.020, +1.0), 1e-10);
}

TEST(Relation, FailsWithTheSignOfTheStiffnessTermFlipped) {
  const ExactDrive exact = drive(120.0);
  for (const double lag_s : {0.0, 0.004, 0.020}) EXPECT_GT(residual(exact, 3, lag_s, -1.0), 0.3) << lag_s;
}

TEST(Relation, PositiveLagsDoNotKnowTheRoadToCome) {
  const ExactDrive exact = drive(120.0);
  const LinearModel model = linear_model(kGeometry, car());
  const auto share = [&](double lag_s) {  // of the road term in the front left wheel's row
    const double road = exact.with_road(3, 1, lag_s) * model.S.row(3).transpose();
    const double stiffness = exact.moments(3, 1, lag_s).w0 * model.Q.row(3).transpose();
    return std::abs(road / stiffness);
  };
  // The contact patch leaves exp(-2 pi 4 V tau): 4e-2 at 4 ms, 5e-8 at 20 ms, of a term that is large at lag
  // 0.
  EXPECT_LT(share(0.020), 1e-4);
  EXPECT_GT(share(0.0), 100.0 * share(0.020));
}

/// Moments of a drive at four speeds, all exact: what solve() would see after infinitely long driving.
DriveMoments exact_moments() {
  DriveMoments sum;
  for (const double speed : {90.0, 103.0, 117.0, 130.0}) {
    const ExactDrive chassis = drive(speed, 5, 15.0);
    const ExactDrive tyre = drive(speed, 5, 80.0);
    sum.sections += 10;
    for (int j = 0; j < kChassisInstrumentsPerSignal; ++j)
      for (int c = 0; c < kCoordinates; ++c) {
        const auto i = static_cast<std::size_t>(j * kCoordinates + c);
        sum.chassis[i] += chassis.moments(c, j, 0.020);
        sum.chassis_power[i] += chassis.power(c, j);
      }
    for (int w = 0; w < kWheels; ++w) {
      auto& wheel = sum.wheel[static_cast<std::size_t>(w)];
      wheel.tyre += tyre.moments(kBodyCoordinates + w, 1, 0.020);
      wheel.tyre_unbalance += tyre.with_reference(kBodyCoordinates + w, 1, 0.020, w);
      // One equation a wheel and speed, weight Om^2: the accelerations of its own order.
      const double om = tyre.omega(w);
      const std::complex<double> j(0.0, 1.0);
      const Eigen::RowVectorXcd Z = tyre.acceleration_phasor(w).transpose();
      sum.harmonic.right[static_cast<std::size_t>(w)][static_cast<std::size_t>(w)] +=
          {om * om * Z, om * Z * j, -Z};
      sum.harmonic.normal(w, w) += om * om * om * om;
    }
  }
  return sum;
}

TEST(Solve, ReturnsTheCarFromExactMoments) {
  ParameterVector known = car();
  known.segment<kTyreDamper - kSpring>(kSpring).setConstant(
      1.0);  // springs, dampers, stabilisers, tyres: unknown
  const auto x = solve(exact_moments(), kGeometry, known);
  ASSERT_TRUE(x.has_value());
  for (int p = 0; p < kEstimatedTyre; ++p) EXPECT_NEAR((*x)(p) / car()(kSpring + p), 1.0, 1e-6) << p;
  for (int w = 0; w < kWheels; ++w) {
    // At 20 ms the contact patch's memory is 1e-6 of the road term and less.
    EXPECT_NEAR((*x)(kEstimatedTyre + w) / car()(kTyre + w), 1.0, 1e-3) << w;
    const std::complex<double> U((*x)(kEstimatedUnbalance + 2 * w), (*x)(kEstimatedUnbalance + 2 * w + 1));
    EXPECT_LT(std::abs(U / kUnbalance[static_cast<std::size_t>(w)] - 1.0), 1e-3) << w;
  }
}

TEST(Solve, SaysNothingWithoutExcitation) {
  EXPECT_FALSE(solve(DriveMoments{}, kGeometry, car()).has_value());
}

TEST(Solve, LeavesUnbalanceOpenWithoutAReference) {
  DriveMoments moments = exact_moments();
  moments.harmonic.normal(1, 1) = 0.0;
  const auto x = solve(moments, kGeometry, car());
  ASSERT_TRUE(x.has_value());
  EXPECT_TRUE(std::isnan((*x)(kEstimatedUnbalance + 2)));
  EXPECT_FALSE(std::isnan((*x)(kEstimatedUnbalance)));
}

}  // namespace
}  // namespace roadbalance::test
