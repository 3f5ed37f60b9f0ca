// What is predicted of exact drives against their own covariances, which Lyapunov's equation gives.
#include "host/analysis/identify/estimators/relation_prediction.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "host/analysis/identify/estimators/test/frequency_drive.hpp"

namespace roadbalance::test {
namespace {

constexpr double kSpeed_m_s = 120.0 / 3.6;
const RelationFilter::Options kFilter{.lags_s = {0.0, 0.020}};

PredictedCar car() {
  return {kReferenceGeometry, linear_model(kReferenceGeometry, reference_car()), kReferenceUnbalance};
}

std::vector<RelationInstrument> instruments(int first_signal, int signals) {
  std::vector<RelationInstrument> all;
  for (std::size_t lag = 0; lag < kFilter.lags_s.size(); ++lag)
    for (int j = 0; j < kFilter.order - 2; ++j)
      for (int s = first_signal; s < first_signal + signals; ++s)
        all.push_back({lag, j * kRelationSignals + s});
  return all;
}

/// Independent roads, as rough as it finds out.
TEST(RelationPrediction, TellsHowInstrumentsGoWithTheRoadsForce) {
  const RoadStatistics independent{
      .left_right_correlation = 0.0, .rear_coherence2 = 0.0, .rear_own_correlation = 0.0};
  const auto measured = frequency_covariances(kSpeed_m_s, independent, kFilter);
  const RelationPrediction prediction(car(), measured, kFilter, 2.0);
  const ExactDrive drive = reference_drive(3.6 * kSpeed_m_s);
  const auto accelerations = instruments(0, kCoordinates);
  for (int wheel = 0; wheel < kWheels; ++wheel) {
    const Eigen::VectorXd road = prediction.road(wheel, accelerations);
    Eigen::VectorXd exact(road.size());
    for (std::size_t a = 0; a < accelerations.size(); ++a) {
      const auto [lag, row] = accelerations[a];
      exact(static_cast<Eigen::Index>(a)) =
          reference_car()(kTyre + wheel) *
          drive.with_road(row % kRelationSignals, row / kRelationSignals, kFilter.lags_s[lag])(wheel);
    }
    // The exact drive's road is flat below 0.3 Hz.
    EXPECT_LT((road - exact).norm(), 1e-3 * exact.norm()) << wheel;
  }
  EXPECT_TRUE(prediction.road(0, instruments(cosine_row(0), 2)).isZero(0.0)) << "angles know no road";
}

/// With the tyre known an unbalance is told to a variance of 2 S_F / (T Om^4) an axis, S_F the two-sided
/// density of the road's force at the wheel's order: demodulation of a line in noise.
TEST(RelationPrediction, TellsTheScatterOfTheAnglesEquations) {
  const RoadStatistics road;
  auto measured = frequency_covariances(kSpeed_m_s, road, kFilter);
  const RelationPrediction prediction(car(), measured, kFilter, 2.0);
  for (int wheel = 0; wheel < kWheels; ++wheel) {
    const double om = measured.omega()(wheel), tyre = reference_car()(kTyre + wheel);
    const std::vector<RelationInstrument> own{{0, cosine_row(wheel)}, {0, sine_row(wheel)}};
    const Eigen::Matrix2d a = prediction.harmonic(wheel, own).rightCols<2>();
    const Eigen::Matrix2d V = prediction.scatter(wheel, own);
    const Eigen::Matrix2d covariance = (a.transpose() * V.inverse() * a).inverse();
    const double variance =
        2.0 * tyre * tyre * road.density(om, kSpeed_m_s) / (measured.seconds * std::pow(om, 4));
    EXPECT_NEAR(covariance(0, 0) / variance, 1.0, 1e-3);
    EXPECT_NEAR(covariance(1, 1) / variance, 1.0, 1e-3);
    EXPECT_NEAR(covariance(0, 1) / variance, 0.0, 1e-3);
  }
}

/// The harmonic part is all there is of the angles' covariances.
TEST(RelationPrediction, TellsTheHarmonicPart) {
  const auto measured = frequency_covariances(kSpeed_m_s, {}, kFilter);
  const RelationPrediction prediction(car(), measured, kFilter, 2.0);
  const auto angles = instruments(cosine_row(0), 2);
  const Eigen::MatrixXd mean = prediction.harmonic(0, angles);
  for (std::size_t a = 0; a < angles.size(); ++a) {
    const LaggedCovariances& c = measured.lag[angles[a].lag];
    const auto row = static_cast<Eigen::Index>(a);
    EXPECT_NEAR(mean(row, 0), c.w0_z(angles[a].row, kBodyCoordinates), 1e-9 * mean.col(0).norm());
    EXPECT_NEAR(mean(row, 1), -c.w2_d(angles[a].row, 0), 1e-9 * mean.col(1).norm());
    EXPECT_NEAR(mean(row, 2), c.w2_d(angles[a].row, 1), 1e-9 * mean.col(2).norm());
  }
}

}  // namespace
}  // namespace roadbalance::test
