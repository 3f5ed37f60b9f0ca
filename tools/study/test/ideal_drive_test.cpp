#include "tools/study/ideal_drive.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "embedded/demo_vehicle.hpp"
#include "host/analysis/identify/demodulation.hpp"
#include "host/analysis/identify/moments.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;

VehicleConfig demo_vehicle() {
  return VehicleConfig::parse(std::string(embedded::kDemoVehicle), "sim/demo/vehicle.toml");
}

/// A flat road, one wheel out of balance: the answer is a phasor that (1) gives in closed form.
TEST(IdealDrive, AnswersAnUnbalanceAsTheModelDoes) {
  const VehicleConfig vehicle = demo_vehicle();
  IdealDrive drive{.scenario = sim::Scenario::read("", vehicle), .speeds_m_s = {25.0, 33.0}, .samples = 5000};
  drive.scenario.road.roughness_m3 = 0.0;
  drive.scenario.parameter_spread = 0.0;
  drive.scenario.wheel = {};
  const Complex unbalance = std::polar(0.030 * 0.19, 0.7);
  drive.scenario.wheel[0].unbalance_kg_m = unbalance;

  const auto stretches = drive_ideally(drive, 3, vehicle);
  ASSERT_EQ(stretches.size(), 2u);
  const LinearModel model = linear_model(geometry_of(vehicle.model), nominal_parameters(vehicle));
  for (const Stretch& stretch : stretches) {
    ASSERT_EQ(stretch.signals.cols(), drive.samples);
    EXPECT_EQ(stretch.road_m.cols(), 0);
    const double om = stretch.omega(0);
    const Eigen::Matrix<Complex, kCoordinates, kCoordinates> dynamic =
        model.Q.cast<Complex>() + Complex(0, om) * model.P.cast<Complex>() -
        (om * om * model.M).cast<Complex>();
    const Eigen::VectorXcd expected =
        -om * om * om * om * unbalance * dynamic.partialPivLu().solve(model.W.col(0).cast<Complex>());
    const Demodulator demodulator(c2_taper(drive.samples, 0.2, 1.0 / drive.rate_hz), drive.rate_hz);
    const Demodulated line = demodulator(stretch.signals, Eigen::Vector4d(om, 0, 0, 0));
    // The remainder is the decay of the ramp's transient and the decimation's ripple, 2e-4.
    for (int c = 0; c < kCoordinates; ++c)
      EXPECT_LT(std::abs(line.Z(0, c) - expected(c)), 5e-4 * expected.norm()) << c;
  }
}

/// Angle by which front left is ahead of rear left, at the first and the last sample.
std::pair<double, double> ahead(const Stretch& stretch) {
  const auto at = [&](Eigen::Index k) {
    const auto angle = [&](int wheel) {
      return Complex(stretch.signals(cosine_row(wheel), k), stretch.signals(sine_row(wheel), k));
    };
    return std::arg(angle(0) * std::conj(angle(2)));
  };
  return {at(0), at(stretch.signals.cols() - 1)};
}

TEST(IdealDrive, DrawsAnglesAtEachSpeedOfWheelsInStep) {
  const VehicleConfig vehicle = demo_vehicle();
  IdealDrive drive{
      .scenario = sim::Scenario::read("", vehicle), .speeds_m_s = {25.0, 29.0, 33.0}, .samples = 1000};
  drive.scenario.parameter_spread = drive.scenario.rolling_radius_spread = 0.0;
  const auto once = drive_ideally(drive, 3, vehicle);
  drive.angles_drawn_at_each_speed = true;
  const auto each = drive_ideally(drive, 3, vehicle), again = drive_ideally(drive, 3, vehicle);
  ASSERT_EQ(each.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(each[k].speed_m_s, drive.speeds_m_s[k]);
    EXPECT_EQ(each[k].signals, again[k].signals);
    const auto [first, last] = ahead(each[k]);
    EXPECT_NEAR(std::remainder(first - last, 2.0 * std::numbers::pi), 0.0, 1e-6);
    EXPECT_NEAR(std::remainder(ahead(once[k]).first - ahead(once[0]).first, 2.0 * std::numbers::pi), 0.0,
                1e-6);
    if (k == 0) continue;
    EXPECT_GT(std::abs(std::remainder(first - ahead(each[k - 1]).first, 2.0 * std::numbers::pi)), 0.05);
  }
  drive.scenario.rolling_radius_spread = 0.003;
  EXPECT_THROW(drive_ideally(drive, 3, vehicle), std::invalid_argument);
  drive.scenario.rolling_radius_spread = 0.0;
  drive.scenario.parameter_spread = 0.1;
  EXPECT_THROW(drive_ideally(drive, 3, vehicle), std::invalid_argument);
}

/// The road that it gives is the one under the tyres: relation (1) for the wheel's row in the frequency
/// domain.
TEST(IdealDrive, TellsTheRoadThatActs) {
  const VehicleConfig vehicle = demo_vehicle();
  IdealDrive drive{.scenario = sim::Scenario::read("", vehicle),
                   .speeds_m_s = {30.0},
                   .samples = 5000,
                   .road_measured = true};
  drive.scenario.parameter_spread = 0.0;
  drive.scenario.wheel = {};
  const Stretch stretch = drive_ideally(drive, 4, vehicle).front();
  ASSERT_EQ(stretch.road_m.cols(), drive.samples);
  const LinearModel model = linear_model(geometry_of(vehicle.model), nominal_parameters(vehicle));
  const Taper taper = c2_taper(drive.samples, 0.5, 1.0 / drive.rate_hz);
  const double om = 2.0 * std::numbers::pi * 12.0;
  const auto phasor = [&](const auto& row) {
    Complex sum = 0.0;
    for (Eigen::Index k = 0; k < drive.samples; ++k)
      sum += taper.value(k) * row(k) * std::polar(1.0, -om * static_cast<double>(k) / drive.rate_hz);
    return sum;
  };
  Eigen::RowVectorXcd Z(kCoordinates);
  for (int c = 0; c < kCoordinates; ++c) Z(c) = phasor(stretch.signals.row(c));
  const InstrumentMoments<Complex> m{Z, Z * Complex(0, 1 / om), -Z / (om * om)};
  for (int w = 0; w < kWheels; ++w) {
    const Complex force = m.force(model, kBodyCoordinates + w);
    const Complex road = model.S(kBodyCoordinates + w, w) * phasor(stretch.road_m.row(w));
    // The taper's own spectrum is 0.2 Hz wide, over which the dynamics change by a few per cent.
    EXPECT_LT(std::abs(force - road), 0.05 * std::abs(road)) << w;
  }
}

}  // namespace
}  // namespace roadbalance
