// Expected: the Cramer-Rao bounds of the car of the derivation, computed by an independent prototype (SciPy):
// 30 g at 0.19 m and 40 degrees on the front left wheel, class A, 4 speeds 110 .. 130 km/h of 40 s each.
#include "tools/study/cramer_rao.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tools/study/estimator_trial.hpp"

namespace roadbalance {
namespace {

constexpr int kRe = kEstimatedUnbalance, kIm = kEstimatedUnbalance + 1;

BoundQuestion question(double rear_coherence2, bool tyre_unknown) {
  const VehicleConfig vehicle = demo_vehicle();
  BoundQuestion question{.geometry = geometry_of(vehicle.model), .parameters = nominal_parameters(vehicle)};
  question.unbalance_kg_m[0] = std::polar(0.030 * 0.19, 40.0 * std::numbers::pi / 180.0);
  question.speeds_m_s = speeds_between(110.0, 130.0, 4);
  question.road.rear_coherence2 = rear_coherence2;
  question.road.rear_own_correlation = 0.0;  // as the prototype had it
  question.random_part = false;
  question.asked.set(kRe).set(kIm);
  if (tyre_unknown) question.asked.set(kEstimatedTyre);
  return question;
}

struct Expected {
  double coherence2, known, tyre, re, im;  ///< standard deviations; of the tyre as part, of U in kg m
};

TEST(CramerRao, OfTheHarmonicPartIsThePrototypes) {
  for (const Expected& e :
       {Expected{0.0, 0.00016680087873973805, 0.1589125678908009, 0.00018523610030024904,
                 0.0007784960159739216},
        {0.9, 5.502253287398002e-05, 0.0524204192263661, 6.11037513424761e-05, 0.0002568021401016736},
        {0.95, 3.900241342601151e-05, 0.037157919780142525, 4.3313050985816646e-05, 0.00018203275483282352},
        {0.99, 1.7476842934418124e-05, 0.016650331882646148, 1.940842431521735e-05, 8.156823092929513e-05}}) {
    const BoundQuestion known = question(e.coherence2, false), unknown = question(e.coherence2, true);
    const WheelBound a = wheel_bound(cramer_rao(known), known, 0);
    // 0.5 %: the prototype's speeds have their own rounding.
    EXPECT_NEAR(a.re_kg_m / e.known, 1.0, 5e-3) << e.coherence2;
    EXPECT_NEAR(a.im_kg_m / e.known, 1.0, 5e-3) << e.coherence2;
    const WheelBound b = wheel_bound(cramer_rao(unknown), unknown, 0);
    EXPECT_NEAR(b.tyre_percent / 100.0 / e.tyre, 1.0, 5e-3) << e.coherence2;
    EXPECT_NEAR(b.re_kg_m / e.re, 1.0, 5e-3) << e.coherence2;
    EXPECT_NEAR(b.im_kg_m / e.im, 1.0, 5e-3) << e.coherence2;
  }
}

/// Table 1: "+ random road part (shape known)": 0.506 % of the tyre from
/// the band up to 60 Hz, whatever the road.
TEST(CramerRao, OfTheRandomPartIsThePrototypes) {
  for (const auto& [roughness, mass_percent] :
       {std::pair{4e-6, 1.50}, {16e-6, 2.94}, {64e-6, 5.86}, {256e-6, 11.7}}) {
    BoundQuestion q = question(0.0, true);
    q.random_part = true;
    q.road.roughness_m3 = roughness;
    const WheelBound bound = wheel_bound(cramer_rao(q), q, 0);
    EXPECT_NEAR(bound.tyre_percent, 0.506, 0.002) << roughness;
    EXPECT_NEAR(bound.mass_percent / mass_percent, 1.0, 4e-3) << roughness;  // as far as it is printed
  }
}

/// One wheel, information by its force alone: sd(U) = 1 / sqrt(sum T Om^4 / (2 S_F)), independent of the
/// suspension.
TEST(CramerRao, OfIndependentRoadsIsTheClosedForm) {
  BoundQuestion q = question(0.0, false);
  q.road.left_right_correlation = 0.0;
  double information = 0.0;
  for (const double speed : q.speeds_m_s) {
    const double om = speed / 0.3,
                 force = q.parameters(kTyre) * q.parameters(kTyre) * q.road.density(om, speed);
    information += q.seconds * std::pow(om, 4) / (2.0 * force);
  }
  EXPECT_NEAR(wheel_bound(cramer_rao(q), q, 0).re_kg_m * std::sqrt(information), 1.0, 1e-9);
  q.parameters.segment<4>(kDamper) *= 1.7;
  EXPECT_NEAR(wheel_bound(cramer_rao(q), q, 0).im_kg_m * std::sqrt(information), 1.0, 1e-9);
}

TEST(CramerRao, GrowsWithWhatIsUnknown) {
  BoundQuestion q = question(0.0, true);
  q.random_part = true;
  q.level_free = false;
  const double least = wheel_bound(cramer_rao(q), q, 0).tyre_percent;
  q.level_free = true;
  const double level = wheel_bound(cramer_rao(q), q, 0).tyre_percent;
  q.exponent_free = true;
  const double exponent = wheel_bound(cramer_rao(q), q, 0).tyre_percent;
  EXPECT_LT(least, level * 0.999);
  EXPECT_LT(level, exponent * 0.999);
}

TEST(CramerRao, RefusesWhatCannotBeTold) {
  BoundQuestion q = question(0.95, true);
  q.unbalance_kg_m = {};  // nothing turns and no road is used: the tyre has no effect
  EXPECT_THROW(cramer_rao(q), std::invalid_argument);
}

TEST(RoadCoherence, IsOfAPossibleRoad) {
  RoadStatistics road{.left_right_correlation = 0.3, .rear_coherence2 = 0.95, .rear_own_correlation = 0.3};
  const Eigen::Matrix4cd R = road.coherence(geometry_of(demo_vehicle().model), 100.0, 33.0);
  EXPECT_LT((R - R.adjoint()).norm(), 1e-15);
  // Two axles and two sides: the determinant of a Kronecker product.
  EXPECT_NEAR(R.determinant().real(), std::pow((1 - 0.09) * (1 - 0.95), 2), 1e-12);
}

}  // namespace
}  // namespace roadbalance
