// The relation's least squares on exact covariances: nothing here is estimated, so the truth must come out.
#include "host/analysis/identify/estimators/relation_least_squares.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "host/analysis/identify/estimators/paper.hpp"
#include "host/analysis/identify/estimators/test/frequency_drive.hpp"
#include "host/analysis/identify/test/reference_car.hpp"

namespace roadbalance::test {
namespace {

using Instruments = RelationInstruments;
using Road = RelationRoad;
constexpr std::array kSpeeds_km_h{110.0, 117.0, 123.0, 130.0};

/// Result of RelationFilter after infinitely long driving.
RelationCovariances exact(const ExactDrive& drive, double speed_km_h, const std::vector<double>& lags_s,
                          int order, double sign_of_w0) {
  RelationCovariances sums;
  sums.seconds = 1.0;
  sums.metres = speed_km_h / 3.6;
  for (int w = 0; w < kWheels; ++w) sums.turned_rad(w) = drive.omega(w);
  const Eigen::Index rows = (order - 2) * kRelationSignals;
  sums.power = Eigen::VectorXd::Zero(rows);
  for (const double lag_s : lags_s) {
    LaggedCovariances c{Eigen::MatrixXd::Zero(rows, kCoordinates),
                        {},
                        {},
                        Eigen::MatrixXd::Zero(rows, 2 * kWheels),
                        Eigen::MatrixXd::Zero(rows, kWheels)};
    c.w1_z = c.w0_z = c.w2_z;
    for (int j = 0; j < order - 2; ++j)
      for (int s = 0; s < kSignals; ++s) {
        const int i = j * kRelationSignals + s;
        const auto m = drive.moments(s, j, lag_s);
        c.w2_z.row(i) = m.w2;
        c.w1_z.row(i) = m.w1;
        c.w0_z.row(i) = sign_of_w0 * m.w0;
        c.w2_u.row(i) = drive.with_road(s, j, lag_s);
        for (int w = 0; w < kWheels; ++w) {
          const std::complex<double> d = drive.with_reference(s, j, lag_s, w);
          c.w2_d.block<1, 2>(i, 2 * w) << d.real(), d.imag();
        }
        sums.power(i) = drive.power(s, j);
      }
    sums.lag.push_back(c);
  }
  return sums;
}

BySpeed<RelationCovariances> exact_drives(const std::vector<double>& lags_s, int order = 5,
                                          double corner_hz = 30.0, double road_gd_m3 = 16e-6,
                                          double sign_of_w0 = 1.0) {
  BySpeed<RelationCovariances> sums;
  int key = 0;
  for (const double speed : kSpeeds_km_h)
    sums.at[key++] =
        exact(reference_drive(speed, order, corner_hz, road_gd_m3), speed, lags_s, order, sign_of_w0);
  return sums;
}

enum class Asked { kWheels, kEverything };

/// Takes nothing of what it asks as known.
Question question(Asked asked) {
  Question q{kReferenceGeometry, reference_car(), {}};
  for (std::size_t i = asked == Asked::kWheels ? kEstimatedTyre : 0; i < kUnknowns; ++i) q.asked.set(i);
  for (int i = 0; i < kEstimatedUnbalance; ++i)
    if (q.asked[static_cast<std::size_t>(i)]) q.known(kSpring + i) = 1.0;
  return q;
}

UnknownVector truth() {
  UnknownVector x;
  x.head<kEstimatedUnbalance>() = reference_car().segment<kEstimatedUnbalance>(kSpring);
  for (int w = 0; w < kWheels; ++w)
    x.segment<2>(kEstimatedUnbalance + 2 * w) << kReferenceUnbalance[static_cast<std::size_t>(w)].real(),
        kReferenceUnbalance[static_cast<std::size_t>(w)].imag();
  return x;
}

/// Largest error, relative to the stiffness or to the size of the unbalance; infinite if nothing was
/// determined.
double error(const std::optional<UnknownVector>& x) {
  if (!x) return std::numeric_limits<double>::infinity();
  double worst = 0.0;
  for (int i = 0; i < kUnknowns; ++i) {
    const double size =
        i < kEstimatedUnbalance
            ? truth()(i)
            : std::abs(kReferenceUnbalance[static_cast<std::size_t>((i - kEstimatedUnbalance) / 2)]);
    worst = std::max(worst, std::abs((*x)(i)-truth()(i)) / size);
  }
  return worst;
}

TEST(RelationLeastSquares, FindsTheCarWithTheRoadMeasured) {
  for (const std::vector<double>& lags : {std::vector{0.0}, std::vector{0.0, 0.004, 0.010}})
    for (const Instruments instruments : {Instruments::kAll, Instruments::kOwn})
      EXPECT_LT(
          error(solve_relation(exact_drives(lags), question(Asked::kWheels), {instruments, Road::kMeasured})),
          1e-8);
}

TEST(RelationLeastSquares, FindsTheSuspensionInTheSameStep) {
  EXPECT_LT(error(solve_relation(exact_drives({0.0, 0.020}), question(Asked::kEverything),
                                 {Instruments::kAll, Road::kMeasured})),
            1e-6);
}

TEST(RelationLeastSquares, TakesAnyOrderAndCorner) {
  EXPECT_LT(error(solve_relation(exact_drives({0.0}, 3, 20.0), question(Asked::kWheels),
                                 {Instruments::kAll, Road::kMeasured})),
            1e-8);
  EXPECT_LT(error(solve_relation(exact_drives({0.0}, 8, 60.0), question(Asked::kWheels),
                                 {Instruments::kAll, Road::kMeasured})),
            1e-8);
}

TEST(RelationLeastSquares, MissesTheTruthWithTheSignOfTheStiffnessTermFlipped) {
  const auto flipped = exact_drives({0.0}, 5, 30.0, 16e-6, -1.0);
  EXPECT_GT(error(solve_relation(flipped, question(Asked::kWheels), {Instruments::kAll, Road::kMeasured})),
            0.5);
}

/// Answers to exact covariances of the instruments and lags of each kind that is shipped.
TEST(RelationLeastSquares, FindsTheCarInEveryShippedWay) {
  for (const auto kinds : {paper_kinds, own_past_kinds})
    for (const EstimatorKind& kind : kinds()) {
      const auto estimator = kind.make(question(Asked::kWheels));
      const RelationOptions& options = dynamic_cast<const RelationEstimator&>(*estimator).options();
      const auto sums = exact_drives(options.filter.lags_s, options.filter.order, options.filter.cutoff_hz);
      EXPECT_LT(error(solve_relation(sums, question(Asked::kWheels), options)), 1e-3) << kind.name;
      EXPECT_LT(error(solve_relation(sums, question(Asked::kEverything), options)), 1e-3) << kind.name;
    }
}

/// Wheels share their roads, rear ones later: what lambda is depends on all of it.
BySpeed<RelationCovariances> shared_roads(const RoadStatistics& road, const RelationFilter::Options& filter) {
  BySpeed<RelationCovariances> sums;
  int key = 0;
  for (const double speed : kSpeeds_km_h) sums.at[key++] = frequency_covariances(speed / 3.6, road, filter);
  return sums;
}

RelationOptions options_of(const char* name) {
  const auto estimator = make_estimator(name, question(Asked::kWheels));
  return dynamic_cast<const RelationEstimator&>(*estimator).options();
}

TEST(RelationLeastSquares, EliminatesARoadThatWheelsShare) {
  for (const char* name : {"paper", "paper-lags", "paper-own"})
    for (const double exponent : {1.5, 2.0, 2.5}) {
      RelationOptions options = options_of(name);
      options.road_exponent = exponent;
      const auto sums = shared_roads({.rear_coherence2 = 0.9, .exponent = exponent}, options.filter);
      EXPECT_LT(error(solve_relation(sums, question(Asked::kWheels), options)), 1e-3)
          << name << " " << exponent;
    }
}

/// The roads' levels are measured at each speed: the exponent only bends their spectrum over the band of the
/// wheels.
TEST(RelationLeastSquares, HardlyNeedsTheExponentOfAnUnknownRoad) {
  for (const char* name : {"paper", "paper-lags", "paper-own"}) {
    const RelationOptions options = options_of(name);
    const auto sums = shared_roads({.exponent = 2.5}, options.filter);
    EXPECT_LT(error(solve_relation(sums, question(Asked::kWheels), options)), 0.02) << name;
  }
}

/// As if each speed had been driven on another road.
TEST(RelationLeastSquares, TakesEachSpeedsRoadAsRoughAsItIs) {
  const RelationOptions options = options_of("paper");
  BySpeed<RelationCovariances> sums;
  for (const double speed : kSpeeds_km_h)
    sums.at[static_cast<int>(speed)] =
        frequency_covariances(speed / 3.6, {.roughness_m3 = 16e-6 * (speed - 100.0)}, options.filter);
  EXPECT_LT(error(solve_relation(sums, question(Asked::kWheels), options)), 1e-3);
}

TEST(RelationLeastSquares, RefusesLagsThatTheFilterHasNot) {
  EXPECT_THROW(solve_relation(exact_drives({0.0, 0.010}), question(Asked::kWheels),
                              {Instruments::kAll, Road::kUnknown}),
               std::invalid_argument);
}

TEST(RelationLeastSquares, NeedsTwoSpeedsWithTheRoadUnknown) {
  BySpeed<RelationCovariances> one;
  one.at[0] = exact_drives({0.0}).at.begin()->second;
  EXPECT_FALSE(
      solve_relation(one, question(Asked::kWheels), {Instruments::kAll, Road::kUnknown}).has_value());
}

TEST(RelationLeastSquares, NeedsNoRoadForTheAngles) {
  EXPECT_LT(error(solve_relation(exact_drives({0.0}), question(Asked::kWheels),
                                 {Instruments::kAngles, Road::kNone})),
            1e-8);
}

TEST(RelationLeastSquares, NeedsNoRoadForThePast) {
  const RelationOptions past{Instruments::kOwn, Road::kNone};
  EXPECT_LT(error(solve_relation(exact_drives({0.010, 0.020, 0.040}), question(Asked::kWheels), past)), 1e-4);
}

/// The contact patch's memory makes lag 0 wrong by some per cent; with negative lags the instrument knows the
/// road.
TEST(RelationLeastSquares, IsWrongWithoutARoadAtLagsThatAreNotPositive) {
  const RelationOptions none{Instruments::kOwn, Road::kNone};
  const double at_zero = error(solve_relation(exact_drives({0.0}), question(Asked::kWheels), none));
  EXPECT_GT(at_zero, 0.03);
  EXPECT_LT(at_zero, 0.20);
  EXPECT_GT(error(solve_relation(exact_drives({-0.020}), question(Asked::kWheels), none)), 0.4);
}

TEST(RelationLeastSquares, LeavesTheUnbalanceOfAWheelWithoutReferenceOpen) {
  auto sums = exact_drives({0.020});
  for (auto& [key, at] : sums.at) at.lag[0].w2_d.middleCols<2>(2).setZero();
  const auto x = solve_relation(sums, question(Asked::kWheels), {Instruments::kOwn, Road::kNone});
  ASSERT_TRUE(x.has_value());
  EXPECT_TRUE(std::isnan((*x)(kEstimatedUnbalance + 2)));
  EXPECT_NEAR((*x)(kEstimatedUnbalance) / truth()(kEstimatedUnbalance), 1.0, 1e-3);
}

}  // namespace
}  // namespace roadbalance::test
