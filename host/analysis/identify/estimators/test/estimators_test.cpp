// Every estimator of the paper's family on a drive of the simulated car behind perfect sensors.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <set>

#include "common/config/section.hpp"
#include "host/analysis/identify/estimators/estimator.hpp"
#include "tools/study/estimator_trial.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
const std::complex<double> kUnbalance = std::polar(0.030 * 0.19, 40.0 * pi / 180.0);

/// The car without spreads, one wheel out of balance.
IdealDrive plain_drive(double road_gd_m3, Eigen::Index samples) {
  const VehicleConfig vehicle = demo_vehicle();
  IdealDrive drive{.scenario = plain_scenario(vehicle),
                   .speeds_m_s = speeds_between(110.0, 130.0, 4),
                   .samples = samples,
                   .road_measured = true};
  drive.scenario.road.roughness_m3 = road_gd_m3;
  drive.scenario.wheel[0].unbalance_kg_m = kUnbalance;
  return drive;
}

/// Tyre and unbalance of the front left wheel, the tyre taken for 10 % stiffer.
Question front_left(double tyre = 1.1) {
  const VehicleConfig vehicle = demo_vehicle();
  Question question{geometry_of(vehicle.model), nominal_parameters(vehicle), {}};
  question.known(kTyre) *= tyre;
  question.asked.set(kEstimatedUnbalance).set(kEstimatedUnbalance + 1);
  if (tyre != 1.0) question.asked.set(kEstimatedTyre);
  return question;
}

EstimatorAnswer answer_of(const std::string& name, const Question& question,
                          const std::vector<Stretch>& stretches) {
  const auto estimator = make_estimator(name, question);
  for (const Stretch& stretch : stretches) estimator->add(stretch);
  return estimator->solve();
}

double tyre_error(const EstimatorAnswer& answer) {
  return answer.x(kEstimatedTyre) / nominal_parameters(demo_vehicle())(kTyre) - 1.0;
}
double unbalance_error(const EstimatorAnswer& answer) {
  return std::abs(std::complex<double>(answer.x(kEstimatedUnbalance), answer.x(kEstimatedUnbalance + 1)) -
                  kUnbalance) /
         std::abs(kUnbalance);
}
double tyre_sigma(const EstimatorAnswer& answer) {
  return std::sqrt(answer.covariance(kEstimatedTyre, kEstimatedTyre)) /
         nominal_parameters(demo_vehicle())(kTyre);
}
double unbalance_sigma(const EstimatorAnswer& answer) {
  return std::sqrt(answer.covariance.block<2, 2>(kEstimatedUnbalance, kEstimatedUnbalance).trace()) /
         std::abs(kUnbalance);
}

TEST(Estimators, HaveNamesOfTheirOwnAndSayWhatTheyDo) {
  std::set<std::string> names;
  for (const EstimatorKind& kind : estimators()) {
    EXPECT_TRUE(names.insert(kind.name).second) << kind.name;
    EXPECT_FALSE(kind.what.empty()) << kind.name;
  }
  EXPECT_EQ(estimators().front().name, "paper");
  EXPECT_THROW(make_estimator("none", front_left()), ConfigError);
}

/// Without a road all is harmonic: what is left are the integration of sampled signals and ends.
TEST(Estimators, FindTheUnbalanceWithoutARoad) {
  const auto stretches = drive_ideally(plain_drive(1e-15, 5000), 1, demo_vehicle());
  for (const char* name : {"paper", "paper-lags", "paper-own", "own-past", "harmonic", "harmonic-ml"}) {
    const EstimatorAnswer answer = answer_of(name, front_left(), stretches);
    EXPECT_LT(std::abs(tyre_error(answer)), 0.02) << name;
    EXPECT_LT(unbalance_error(answer), 0.02) << name;
  }
  EXPECT_LT(unbalance_error(answer_of("correlation", front_left(1.0), stretches)), 2e-3);
}

/// A damped tyre's response to the road's rate of change is not in the equations: a diagnostic reports it.
TEST(Estimators, SayThatTheyLeaveOutTheTyresDampingOnAMeasuredRoad) {
  const auto stretches = drive_ideally(plain_drive(16e-6, 2500), 1, demo_vehicle());
  Question damped = front_left();
  damped.known.segment<kWheels>(kTyreDamper).setConstant(100.0);
  const auto mentions = [&](const char* name, const Question& question) {
    for (const std::string& diagnostic : answer_of(name, question, stretches).diagnostics)
      if (diagnostic.find("tyre_damper_n_s_m") != std::string::npos) return true;
    return false;
  };
  for (const char* name : {"paper-road", "windowed-road"}) {
    EXPECT_TRUE(mentions(name, damped)) << name;
    EXPECT_FALSE(mentions(name, front_left())) << name;
  }
  EXPECT_FALSE(mentions("own-past", damped)) << "the road to come is as unknown as its rate of change";
}

/// 10 s a speed, class A: within 4 of the standard deviations that they state themselves, and of the size
/// that Monte Carlo tables of the method give (5000 samples).
TEST(Estimators, KnowHowWrongTheyAre) {
  const auto stretches = drive_ideally(plain_drive(16e-6, 5000), 2, demo_vehicle());
  struct Expected {
    const char* name;
    double tyre, unbalance;  // 95 % of the errors are below
    bool honest = true;      // its ± holds all; else noise in the coefficients pulls it off, and it says so
  };
  for (const Expected& e : {Expected{"own-past", 0.11, 0.25},
                            {"own-past-windowed", 0.11, 0.25},
                            {"harmonic", 0.8, 0.8, false},
                            {"harmonic-ml", 0.5, 0.8},
                            {"paper-road", 0.06, 0.15},
                            {"paper-road-lags", 0.06, 0.1}}) {
    const EstimatorAnswer answer = answer_of(e.name, front_left(), stretches);
    EXPECT_LT(std::abs(tyre_error(answer)), e.tyre) << e.name;
    EXPECT_LT(unbalance_error(answer), e.unbalance) << e.name;
    if (e.honest) {
      EXPECT_LT(std::abs(tyre_error(answer)), 4.0 * tyre_sigma(answer)) << e.name;
      EXPECT_LT(unbalance_error(answer), 4.0 * unbalance_sigma(answer)) << e.name;
    } else {
      EXPECT_FALSE(answer.diagnostics.empty()) << e.name;
    }
    EXPECT_EQ(answer.x(kEstimatedTyre + 1), front_left().known(kTyre + 1)) << e.name;
    EXPECT_EQ(answer.covariance(kEstimatedTyre + 1, kEstimatedTyre + 1), 0.0) << e.name;
  }
}

/// 40 s a speed, class A: four times what the harmonic part alone tells, 15.9 % of the stiffness and 14 % of
/// the unbalance (10.1 % along, 5.6 deg across), and within 4 of their own standard deviations.  With 10 s
/// the bound is as wide as the response is linear, and stiffnesses come out negative.
TEST(Estimators, ComeNearTheBoundOfTheHarmonicPartWithTheRoadEliminated) {
  const auto stretches = drive_ideally(plain_drive(16e-6, 20000), 11, demo_vehicle());
  for (const char* name : {"paper", "paper-lags", "paper-own"}) {
    const EstimatorAnswer answer = answer_of(name, front_left(), stretches);
    EXPECT_LT(std::abs(tyre_error(answer)), 4.0 * 0.159) << name;
    EXPECT_LT(unbalance_error(answer), 4.0 * 0.14) << name;
    EXPECT_LT(std::abs(tyre_error(answer)), 4.0 * tyre_sigma(answer)) << name;
    EXPECT_LT(unbalance_error(answer), 4.0 * unbalance_sigma(answer)) << name;
    EXPECT_FALSE(answer.diagnostics.empty()) << name << " rests on the unbalance's own vibration";
  }
}

/// The window takes the ends away, which are all that the measured road leaves.
TEST(Estimators, AreExactForAFiniteRecordWithTheRoadMeasuredAndAWindow) {
  const auto stretches = drive_ideally(plain_drive(16e-6, 5000), 3, demo_vehicle());
  const EstimatorAnswer windowed = answer_of("windowed-road", front_left(), stretches);
  EXPECT_LT(std::abs(tyre_error(windowed)), 1e-3);
  EXPECT_LT(unbalance_error(windowed), 2e-3);
  EXPECT_LT(std::abs(tyre_error(windowed)),
            std::abs(tyre_error(answer_of("paper-road", front_left(), stretches))));
}

TEST(Estimators, SayWhatTheDriveLacks) {
  auto stretches = drive_ideally(plain_drive(16e-6, 5000), 4, demo_vehicle());
  for (Stretch& stretch : stretches) stretch.road_m.resize(kWheels, 0);
  const std::vector<Stretch> one_speed{stretches.front()};
  for (const auto& [name, drive] :
       {std::pair<std::string, const std::vector<Stretch>*>{"windowed-road", &stretches},
        {"paper", &one_speed}}) {
    const EstimatorAnswer answer = answer_of(name, front_left(), *drive);
    EXPECT_TRUE(std::isnan(answer.x(kEstimatedTyre))) << name;
    EXPECT_TRUE(std::isnan(answer.covariance(kEstimatedTyre, kEstimatedTyre))) << name;
    EXPECT_FALSE(answer.diagnostics.empty()) << name;
  }
  for (const EstimatorKind& kind : estimators()) {
    const EstimatorAnswer nothing = kind.make(front_left())->solve();
    EXPECT_TRUE(std::isnan(nothing.x(kEstimatedUnbalance))) << kind.name;
  }
}

TEST(Correlation, RefusesWheelsThatDoNotDifferInFrequencyLongEnough) {
  IdealDrive drive = plain_drive(16e-6, 5000);
  Question both = front_left(1.0);
  both.asked.set(kEstimatedUnbalance + 2).set(kEstimatedUnbalance + 3);
  drive.scenario.rolling_radius_spread = 0.0;
  const EstimatorAnswer in_step = answer_of("correlation", both, drive_ideally(drive, 5, demo_vehicle()));
  EXPECT_TRUE(std::isnan(in_step.x(kEstimatedUnbalance)));
  EXPECT_TRUE(std::isnan(in_step.x(kEstimatedUnbalance + 2)));
  ASSERT_FALSE(in_step.diagnostics.empty());
  EXPECT_NE(in_step.diagnostics.front().find("front_left is not separated from front_right"),
            std::string::npos);

  // Seed 5 draws radii that differ by more than 1 turn in 40 s of 17 Hz: 0.15 %.
  drive.scenario.rolling_radius_spread = 0.01;
  const auto apart = drive_ideally(drive, 5, demo_vehicle());
  ASSERT_GT(std::abs(apart[0].omega(0) / apart[0].omega(1) - 1.0), 0.003);
  const EstimatorAnswer answer = answer_of("correlation", both, apart);
  EXPECT_LT(unbalance_error(answer), 4.0 * unbalance_sigma(answer));
  EXPECT_LT(unbalance_error(answer), 0.3);
}

TEST(Correlation, SaysWhenTheForceDoesNotGrowWithTheSquareOfTheSpeed) {
  IdealDrive drive = plain_drive(1e-15, 5000);
  drive.speeds_m_s = speeds_between(80.0, 130.0, 4);
  EXPECT_TRUE(
      answer_of("correlation", front_left(1.0), drive_ideally(drive, 6, demo_vehicle())).diagnostics.empty());
  drive.scenario.wheel[0].unbalance_kg_m = 0.0;
  drive.scenario.wheel[0].radial_force_n = 30.0;
  const EstimatorAnswer radial =
      answer_of("correlation", front_left(1.0), drive_ideally(drive, 6, demo_vehicle()));
  ASSERT_EQ(radial.diagnostics.size(), 1u);
  EXPECT_NE(radial.diagnostics.front().find("0.0 ± 0.0"), std::string::npos) << radial.diagnostics.front();
}

/// 120 s at 100 km/h, noise of 0.01 m/s^2; Monte Carlo tables of the method: springs 0.5 .. 1.5 %, dampers
/// 0.1 .. 0.2 %, stabilisers 1.2 .. 1.6 % (one standard deviation).
TEST(Chassis, FindsTheSuspension) {
  IdealDrive drive = plain_drive(16e-6, 60000);
  drive.speeds_m_s = {100.0 / 3.6};
  drive.road_measured = false;
  const VehicleConfig vehicle = demo_vehicle();
  const ParameterVector truth = nominal_parameters(vehicle);
  Question question{geometry_of(vehicle.model), truth, suspension_unknowns()};
  question.known.segment<kEstimatedTyre>(kSpring) *= 1.2;
  question.asked.set(kEstimatedTyre);
  auto stretches = drive_ideally(drive, 7, vehicle);
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0.0, 0.01);
  for (double& value : stretches.front().signals.topRows<kCoordinates>().reshaped()) value += noise(random);
  const EstimatorAnswer answer = answer_of("chassis", question, stretches);
  const auto error = [&](int i) { return std::abs(answer.x(i) / truth(kSpring + i) - 1.0); };
  for (int i = 0; i < kWheels; ++i) {
    EXPECT_LT(error(kEstimatedSpring + i), 0.05) << i;
    EXPECT_LT(error(kEstimatedDamper + i), 0.01) << i;
  }
  for (int i = 0; i < kAxles; ++i) EXPECT_LT(error(kEstimatedStabiliser + i), 0.06) << i;
  for (int i = 0; i < kEstimatedTyre; ++i)
    EXPECT_LT(error(i) * truth(kSpring + i), 4.5 * std::sqrt(answer.covariance(i, i))) << i;
  EXPECT_TRUE(std::isnan(answer.x(kEstimatedTyre)));
  EXPECT_FALSE(answer.diagnostics.empty());
}

}  // namespace
}  // namespace roadbalance
