// Sections of a synthetic drive without road, where the answer is known in closed form.
#include "host/analysis/identify/section.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "common/test/source.hpp"
#include "common/vehicle/sensor_map.hpp"
#include "host/analysis/identify/confidence.hpp"
#include "host/analysis/identify/estimate.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

const VehicleConfig& car() {
  static const VehicleConfig vehicle = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  return vehicle;
}
const Eigen::MatrixXd& sensors() {
  static const Eigen::MatrixXd readings = SensorMap::from(car()).readings;
  return readings;
}
const std::array<Complex, kWheels> kUnbalance{std::polar(6.65e-3, 3.79), std::polar(3.8e-3, 1.05),
                                              std::polar(2.3e-3, -0.4), std::polar(2.7e-3, 2.2)};

/// Phasors of the seven accelerations for a unit unbalance of one wheel at `omega`.
Eigen::VectorXcd response(int wheel, double omega) {
  const LinearModel model = linear_model(geometry_of(car().model), nominal_parameters(car()));
  const Eigen::MatrixXcd dynamic = model.Q + Complex(0, omega) * model.P - omega * omega * model.M;
  return -omega * omega * dynamic.partialPivLu().solve(model.W.col(wheel).cast<Complex>()) * omega * omega;
}

/// Feeds `seconds` at wheel rates omega(i) with white noise on the accelerations; the angles begin anywhere.
void feed(SectionBuilder& sections, const Eigen::Vector4d& omega, double seconds, double noise_m_s2) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0.0, noise_m_s2);
  std::vector<Eigen::VectorXcd> unit;
  for (int w = 0; w < kWheels; ++w)
    unit.push_back(response(w, omega(w)) * kUnbalance[static_cast<std::size_t>(w)]);
  const auto samples = static_cast<int>(seconds * 500.0);
  for (int k = 0; k < samples; ++k) {
    IdentificationSample sample;
    sample.restart = k == 0;
    sample.signals.setZero();
    for (int w = 0; w < kWheels; ++w) {
      const Complex r = std::polar(1.0, omega(w) * k / 500.0 + w);
      sample.signals.head<kCoordinates>() += (unit[static_cast<std::size_t>(w)] * r).real();
      sample.signals(cosine_row(w)) = r.real();
      sample.signals(sine_row(w)) = r.imag();
    }
    for (int c = 0; c < kCoordinates; ++c) sample.signals(c) += noise(random);
    sample.readings = sensors() * sample.signals.head<kCoordinates>();
    sections.consume(sample);
  }
}

Eigen::Vector4cd unbalances(const DriveMoments& moments) {
  const LinearModel model = linear_model(geometry_of(car().model), nominal_parameters(car()));
  Eigen::Vector4cd right = Eigen::Vector4cd::Zero();
  for (int i = 0; i < kWheels; ++i)
    for (int j = 0; j < kWheels; ++j)
      right(i) += moments.harmonic.right[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)].force(
          model, kBodyCoordinates + j);
  return moments.harmonic.normal.inverse() * right;
}

TEST(HarmonicInstrument, FindsTheUnbalanceOfEveryWheelInOneSection) {
  DriveMoments drive;
  SectionBuilder sections(
      car(), [&](const DriveMoments& section) { drive += section; }, sensors());
  feed(sections, {108.0, 108.4, 107.7, 109.0}, 14.0, 1e-4);
  ASSERT_EQ(drive.sections, 1);
  const Eigen::Vector4cd U = unbalances(drive);
  for (int i = 0; i < kWheels; ++i)
    EXPECT_LT(std::abs(U(i) / kUnbalance[static_cast<std::size_t>(i)] - 1.0), 1e-3)
        << kWheelNames[static_cast<std::size_t>(i)];
}

TEST(HarmonicInstrument, StaysRightWhenAllWheelsTurnInStep) {
  DriveMoments drive;
  SectionBuilder sections(
      car(), [&](const DriveMoments& section) { drive += section; }, sensors());
  feed(sections, {108.0, 108.0, 108.0, 108.0}, 14.0, 1e-4);
  ASSERT_EQ(drive.sections, 1);
  const Eigen::Vector4cd U = unbalances(drive);
  for (int i = 0; i < kWheels; ++i)
    EXPECT_LT(std::abs(U(i) / kUnbalance[static_cast<std::size_t>(i)] - 1.0), 1e-2)
        << kWheelNames[static_cast<std::size_t>(i)];
}

TEST(SectionBuilder, WeighsWhatWasDrivenBeforeTheCarWasKnownAsIfItHadKnownIt) {
  ParameterVector known = nominal_parameters(car());
  known.segment<kWheels>(kTyre) *= 1.1;
  known.segment<kWheels>(kDamper) *= 0.8;
  std::vector<DrivenSection> early, late;
  SectionBuilder sections(
      car(), [&](const DrivenSection& section) { early.push_back(section); }, sensors());
  SectionBuilder knowing(
      car(), [&](const DrivenSection& section) { late.push_back(section); }, sensors());
  knowing.set_parameters(known);
  for (SectionBuilder* each : {&sections, &knowing}) feed(*each, {100.0, 101.0, 102.5, 98.0}, 14.0, 0.3);
  ASSERT_EQ(early.size(), 1U);
  ASSERT_EQ(late.size(), 1U);
  const Eigen::Matrix4cd before = early[0].harmonic.normal, wanted = late[0].harmonic.normal;
  EXPECT_GT((before - wanted).norm(), 0.02 * wanted.norm());
  sections.set_parameters(known);
  sections.weigh_anew(early[0]);
  EXPECT_LT((early[0].harmonic.normal - wanted).norm(), 1e-12 * wanted.norm());
  for (int i = 0; i < kWheels; ++i)
    for (std::size_t j = 0; j < kWheels; ++j) {
      const auto& anew = early[0].harmonic.right[static_cast<std::size_t>(i)][j].w2;
      const auto& then = late[0].harmonic.right[static_cast<std::size_t>(i)][j].w2;
      EXPECT_LT((anew - then).norm(), 1e-12 * then.norm());
    }
}

TEST(SectionBuilder, KnowsSpeedAndLength) {
  std::vector<DriveMoments> found;
  SectionBuilder sections(
      car(), [&](const DriveMoments& section) { found.push_back(section); }, sensors());
  feed(sections, {100.0, 100.1, 100.2, 100.3}, 24.0, 1e-4);
  // 3 s of settling, then 10 s a section, 1 s of which it shares with the next, and 20 ms for the longest
  // lag.
  ASSERT_EQ(found.size(), 2U);
  EXPECT_DOUBLE_EQ(found[0].seconds, 9.0);
  EXPECT_NEAR(found[0].speed_seconds / found[0].seconds, 30.0, 0.01);
}

TEST(SectionBuilder, TakesNothingThatASensorHasSpoiled) {
  for (const bool spoiled : {false, true}) {
    DriveMoments drive;
    SectionBuilder sections(
        car(), [&](const DriveMoments& section) { drive += section; }, sensors());
    feed(sections, {108.0, 108.4, 107.7, 109.0}, 3.0 + 7.5, 1e-4);
    sections.consume({.signals = SignalVector::Zero(),
                      .readings = Eigen::VectorXd::Zero(sensors().rows()),
                      .restart = true,
                      .spoiled = spoiled});
    EXPECT_EQ(drive.sections, spoiled ? 0 : 1);
    EXPECT_FALSE(sections.running());
  }
}

TEST(SectionBuilder, TellsOfTheSectionBeingDrivenAsFarAsItGoes) {
  DriveMoments drive;
  SectionBuilder sections(
      car(), [&](const DriveMoments& section) { drive += section; }, sensors());
  feed(sections, {108.0, 108.4, 107.7, 109.0}, 3.0 + 4.9, 1e-4);
  EXPECT_FALSE(sections.running()) << "less than five seconds";
  const auto before = sections.news();
  SectionBuilder longer(
      car(), [&](const DriveMoments& section) { drive += section; }, sensors());
  feed(longer, {108.0, 108.4, 107.7, 109.0}, 3.0 + 6.5, 1e-4);
  EXPECT_EQ(drive.sections, 0);
  EXPECT_GT(longer.news(), before);
  const auto running = longer.running();
  ASSERT_TRUE(running);
  EXPECT_DOUBLE_EQ(running->seconds, 5.0) << "six whole parts, less what sections have in common";
  const Eigen::Vector4cd U = unbalances(*running);
  for (int i = 0; i < kWheels; ++i)
    EXPECT_LT(std::abs(U(i) / kUnbalance[static_cast<std::size_t>(i)] - 1.0), 3e-3)
        << kWheelNames[static_cast<std::size_t>(i)];
  EXPECT_EQ(longer.running()->harmonic.normal, running->harmonic.normal) << "asking changes nothing";
}

TEST(SectionBuilder, UsesWhatAHoleLeavesOfASection) {
  std::vector<DriveMoments> found;
  SectionBuilder sections(
      car(), [&](const DriveMoments& section) { found.push_back(section); }, sensors());
  feed(sections, {108.0, 108.4, 107.7, 109.0}, 3.0 + 7.9, 1e-4);
  EXPECT_TRUE(found.empty());
  const auto before = sections.news();
  feed(sections, {108.0, 108.4, 107.7, 109.0}, 3.0 + 2.0, 1e-4);  // begins with a restart
  ASSERT_EQ(found.size(), 1U);
  EXPECT_DOUBLE_EQ(found[0].seconds, 6.0);
  EXPECT_GT(sections.news(), before) << "the section that was being driven is no more";
  const Eigen::Vector4cd U = unbalances(found[0]);
  for (int i = 0; i < kWheels; ++i)
    EXPECT_LT(std::abs(U(i) / kUnbalance[static_cast<std::size_t>(i)] - 1.0), 3e-3)
        << kWheelNames[static_cast<std::size_t>(i)];
}

TEST(SectionBuilder, UsesNoSectionInWhichAWheelHasNoAngleAndNamesIt) {
  int found = 0;
  SectionBuilder sections(
      car(), [&](const DriveMoments&) { ++found; }, sensors());
  IdentificationSample sample;
  for (int k = 0; k < 500 * 14; ++k) {
    sample.restart = k == 0;
    sample.signals.setZero();
    for (const int w : {0, 1, 3}) {  // the encoder of rear_left is broken
      sample.signals(cosine_row(w)) = std::cos(0.2 * k);
      sample.signals(sine_row(w)) = std::sin(0.2 * k);
    }
    sample.readings = sensors() * sample.signals.head<kCoordinates>();
    sections.consume(sample);
  }
  EXPECT_EQ(found, 0);
  EXPECT_EQ(sections.missing_reference(), 2);
}

TEST(SectionBuilder, UsesNoDrivingBelowTheLeastSpeed) {
  int found = 0;
  SectionBuilder sections(
      car(), [&](const DriveMoments&) { ++found; }, sensors());
  feed(sections, Eigen::Vector4d::Constant(0.9 * car().drive.least_speed_m_s / 0.30), 30.0, 1e-4);
  EXPECT_EQ(found, 0);
}

TEST(Jackknife, GivesTheVarianceOfAMean) {
  // With exact suspension and tyre moments and no coupling, U of a wheel is a plain mean over the groups; the
  // jackknife of a mean is s^2 / n exactly.
  const Geometry geometry = geometry_of(car().model);
  const ParameterVector known = nominal_parameters(car());
  std::vector<DriveMoments> groups;
  DriveMoments total;
  SectionBuilder sections(
      car(), [&](const DriveMoments& section) { groups.push_back(section); }, sensors());
  std::mt19937_64 random(3);
  std::normal_distribution<double> road(0.0, 1.0);
  for (int k = 0; k < 500 * 34; ++k) {  // noise drives every instrument, so that step 1 is determined
    IdentificationSample sample;
    sample.restart = k == 0;
    for (int c = 0; c < kCoordinates; ++c) sample.signals(c) = road(random);
    for (int w = 0; w < kWheels; ++w) {
      sample.signals(cosine_row(w)) = std::cos(0.2 * k);
      sample.signals(sine_row(w)) = std::sin(0.2 * k);
    }
    sample.readings = sensors() * sample.signals.head<kCoordinates>();
    sections.consume(sample);
  }
  ASSERT_EQ(groups.size(), 3U);
  // Same instruments everywhere, so x does not vary but by U: the right side of group g is shifted by U_g.
  for (std::size_t g = 1; g < groups.size(); ++g) groups[g] = groups[0];
  const std::array<double, 3> shift{1.0, 2.0, 6.0};
  for (std::size_t g = 0; g < groups.size(); ++g) {
    groups[g].harmonic = HarmonicMoments{};
    groups[g].wheel[0].tyre_unbalance = 0.0;
    groups[g].harmonic.normal(0, 0) = 1.0;
    // A force of `shift` on wheel 0's row through its mass, which is known.
    groups[g].harmonic.right[0][0].w2(kBodyCoordinates) = shift[g] / known(kWheelMass);
  }
  const auto covariance =
      jackknife_covariance(groups, [&](const DriveMoments& rest) { return solve(rest, geometry, known); });
  ASSERT_TRUE(covariance.has_value());
  const double variance = (4.0 + 1.0 + 9.0) / 2.0;  // about the mean 3
  EXPECT_NEAR((*covariance)(kEstimatedUnbalance, kEstimatedUnbalance), variance / 3.0, 1e-9);
  EXPECT_NEAR((*covariance)(kEstimatedSpring, kEstimatedSpring), 0.0, 1e-3);
}

}  // namespace
}  // namespace roadbalance
