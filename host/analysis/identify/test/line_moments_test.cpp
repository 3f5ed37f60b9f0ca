#include "host/analysis/identify/line_moments.hpp"

#include <gtest/gtest.h>

#include "common/dsp/taper.hpp"
#include "host/analysis/identify/car_posterior.hpp"
#include "tools/study/estimator_trial.hpp"
#include "tools/study/ideal_drive.hpp"

namespace roadbalance {
namespace {

constexpr std::uint64_t kSeed = 4;

Stretch drive(const VehicleConfig& vehicle) {
  const IdealDrive ideal{
      .scenario = sim::Scenario::read("", vehicle), .speeds_m_s = {30.0}, .samples = 10000};
  return drive_ideally(ideal, kSeed, vehicle).front();
}

HarmonicReading read(const Stretch& stretch, const Eigen::ArrayXd& quiet) {
  const Eigen::Index samples = stretch.signals.cols();
  const HarmonicInstrument instrument(
      geometry_of(demo_vehicle().model),
      c2_taper(samples, stretch.rate_hz / static_cast<double>(samples), 1.0 / stretch.rate_hz),
      stretch.rate_hz);
  return instrument.read(stretch.signals, stretch.omega, stretch.speed_m_s, stretch.readings, quiet);
}

// What the channels give, by their map to the seven coordinates, is what the coordinates themselves give.
TEST(LineMoments, ChannelsGiveTheForcesOfTheCoordinates) {
  const VehicleConfig vehicle = demo_vehicle();
  const CarPrior prior = CarPrior::of(vehicle);
  const Stretch stretch = drive(vehicle);
  const HarmonicReading section = read(stretch, Eigen::ArrayXd::Ones(stretch.signals.cols()));
  const LineMoments lines =
      line_moments(section, prior.sensors.rows(), section.density(), prior.geometry, prior.value);
  const HarmonicMoments harmonic =
      harmonic_moments(section.lines, prior.geometry, prior.value, section.road, RoadShare::kShared);
  EXPECT_LT((lines.normal - harmonic.normal).norm(), 1e-9 * harmonic.normal.norm());

  SpectralMoments empty;
  empty.frequency_hz = Eigen::ArrayXd::Constant(1, 0.75);
  empty.segments = 1.0;
  empty.delay_seconds = 0.1;
  empty.count.setZero(1);
  empty.same.assign(1, Eigen::MatrixXcd::Zero(3 * prior.sensors.rows() + kStrutSignals,
                                              3 * prior.sensors.rows() + kStrutSignals));
  empty.delayed = empty.same;
  const CarPosterior car(prior, {{&empty}});
  const Eigen::Vector4cd b = lines.right_sides(
      car.wheel_forces(Eigen::VectorXd::Zero(car.size())).leftCols(3 * prior.sensors.rows()));
  const LinearModel model = linear_model(prior.geometry, prior.value);
  for (int i = 0; i < kWheels; ++i) {
    std::complex<double> expected = 0.0;
    for (int j = 0; j < kWheels; ++j)
      expected += harmonic.right[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)].force(
          model, kBodyCoordinates + j);
    EXPECT_LT(std::abs(b(i) - expected), 1e-8 * std::abs(expected)) << i;
  }
}

// Half of a section that is not quiet leaves the line where it is, and half of its weight.
TEST(LineMoments, WhatIsNotQuietIsLeftOut) {
  const VehicleConfig vehicle = demo_vehicle();
  const CarPrior prior = CarPrior::of(vehicle);
  Stretch stretch = drive(vehicle);
  const Eigen::Index half = stretch.signals.cols() / 2;
  Eigen::ArrayXd quiet = Eigen::ArrayXd::Ones(stretch.signals.cols());
  quiet.tail(half).setZero();
  const HarmonicReading before = read(stretch, quiet);
  stretch.readings.rightCols(half).setConstant(1e6);
  stretch.signals.topRightCorner(kCoordinates, half).setConstant(1e6);
  const HarmonicReading after = read(stretch, quiet);
  EXPECT_EQ(before.readings, after.readings);
  EXPECT_DOUBLE_EQ(before.seconds, 0.5 * static_cast<double>(stretch.signals.cols()) / stretch.rate_hz);
  const LineMoments lines =
      line_moments(after, prior.sensors.rows(), after.density(), prior.geometry, prior.value);
  const LineMoments same =
      line_moments(before, prior.sensors.rows(), after.density(), prior.geometry, prior.value);
  EXPECT_EQ(lines.normal, same.normal);
}

}  // namespace
}  // namespace roadbalance
