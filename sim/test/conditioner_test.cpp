#include "sim/conditioner.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "sim/test/test_car.hpp"

namespace roadbalance::sim {
namespace {

using Complex = std::complex<double>;
constexpr double kPi = std::numbers::pi;
constexpr double kStep_s = 1.0 / 4000.0;

/// Butterworth low-pass by its poles w e^{j pi (2k + n + 1) / 2n}.
Complex butterworth_gain(int order, double cutoff_hz, double frequency_hz) {
  Complex gain = 1.0;
  const Complex s(0.0, frequency_hz / cutoff_hz);
  for (int k = 0; k < order; ++k) gain /= s - std::polar(1.0, kPi * (2.0 * k + order + 1.0) / (2.0 * order));
  return gain;
}

/// Counts of `channel` of the front node over `scans` scans, sources given as a function of time.
template <typename Sources>
std::vector<Scan> convert(const Scenario& scenario, const VehicleConfig& vehicle, int scans,
                          Sources sources) {
  Conditioner conditioner(scenario, 1, vehicle, vehicle.node[0], kStep_s);
  std::vector<Scan> result(static_cast<std::size_t>(scans));
  for (int k = 0; k < 2 * scans; ++k) {
    conditioner.feed(sources(k * kStep_s), k);
    if (k % 2 == 0) conditioner.convert(result[static_cast<std::size_t>(k / 2)]);
  }
  return result;
}

TEST(Conditioner, CountsCarryAmplitudeAndPhaseThroughTheAntiAliasingFilter) {
  const VehicleConfig vehicle = test::reference_vehicle();
  const ChannelConfig& channel = vehicle.node[0].channel[2];  // z on the front left carrier
  for (const double frequency_hz : {5.0, 18.0, 120.0, 200.0}) {
    const auto scans = convert(test::ideal_scenario(30.0), vehicle, 6000, [&](double t) {
      SourceVector sources = SourceVector::Zero();
      sources(kBodyCoordinates) = 3.0 * std::cos(2.0 * kPi * frequency_hz * t);
      return sources;
    });
    Complex sum = 0.0;
    for (std::size_t k = 4000; k < 6000; ++k)  // 1 s, whole periods
      sum += channel.to_si(scans[k].counts[2]) *
             std::polar(2.0 / 2000.0, -2.0 * kPi * frequency_hz * static_cast<double>(k) / 2000.0);
    // Straight lines between the steps multiply by sinc^2(f step).
    const double x = kPi * frequency_hz * kStep_s;
    const Complex expected = 3.0 * butterworth_gain(6, 200.0, frequency_hz) * std::pow(std::sin(x) / x, 2);
    // Rounding is half a count of 2.4e-5 m/s^2, and averages little where the same few values repeat.
    EXPECT_LT(std::abs(sum - expected), 1.2e-5) << frequency_hz;
  }
}

TEST(Conditioner, SensorsFeelTheRigidBodyAtTheirPlace) {
  const VehicleConfig vehicle = test::reference_vehicle();
  const NodeConfig& node = vehicle.node[0];
  SourceVector sources = SourceVector::Zero();
  sources.head<3>() << 0.5, 0.2, -0.3;  // heave, roll, pitch
  sources(kForwardSource + 1) = 1.5;
  sources(kLeftSource + 1) = -0.7;
  sources(kDriveSource) = 0.1;
  const auto scans = convert(test::ideal_scenario(30.0), vehicle, 2000, [&](double) { return sources; });
  const auto value = [&](std::size_t c) { return node.channel[c].to_si(scans.back().counts[c]); };
  const double count = node.channel[0].scale_m_s2_per_count;
  // Front right carrier (channels 3, 4, 5), right strut top (9, 10, 11) at (1.25, -0.74, 0.30).
  EXPECT_NEAR(value(3), 1.5 + 0.1, count);
  EXPECT_NEAR(value(4), -0.7, count);
  EXPECT_NEAR(value(5), 0.0, count);
  EXPECT_NEAR(value(9), 0.30 * -0.3 + 0.1, count);
  EXPECT_NEAR(value(10), -0.30 * 0.2, count);
  EXPECT_NEAR(value(11), 0.5 + -0.74 * 0.2 - 1.25 * -0.3, count);
}

TEST(Conditioner, AxesCouple) {
  Scenario scenario = test::ideal_scenario(30.0);
  scenario.sensor.coupling_from_vertical = 0.02;
  scenario.sensor.coupling_into_vertical = 0.003;
  const VehicleConfig vehicle = test::reference_vehicle();
  SourceVector sources = SourceVector::Zero();
  sources(kBodyCoordinates) = 10.0;
  sources(kForwardSource) = 4.0;
  const auto scans = convert(scenario, vehicle, 2000, [&](double) { return sources; });
  const auto value = [&](std::size_t c) { return vehicle.node[0].channel[c].to_si(scans.back().counts[c]); };
  EXPECT_NEAR(value(0), 4.0 + 0.2, 2.4e-5);
  EXPECT_NEAR(value(1), 0.2, 2.4e-5);
  EXPECT_NEAR(value(2), 10.0 + 0.012, 2.4e-5);
}

TEST(Conditioner, NoiseHasTheGivenStrengthAndIsItsOwnInEveryChannel) {
  Scenario scenario = test::ideal_scenario(30.0);
  scenario.sensor.noise_m_s2 = 0.02;
  const VehicleConfig vehicle = test::reference_vehicle();
  constexpr int kScans = 20'000;
  const auto scans =
      convert(scenario, vehicle, kScans, [](double) { return SourceVector(SourceVector::Zero()); });
  const double scale = vehicle.node[0].channel[0].scale_m_s2_per_count;
  double a = 0.0, b = 0.0, ab = 0.0;
  for (const Scan& scan : scans) {
    a += std::pow(scale * scan.counts[0], 2) / kScans;
    b += std::pow(scale * scan.counts[5], 2) / kScans;
    ab += scale * scale * scan.counts[0] * scan.counts[5] / kScans;
  }
  // 200 Hz of bandwidth for 10 s are about 4000 independent values: variance good to sqrt(2 / 4000) = 2.2 %.
  EXPECT_NEAR(a / 4e-4, 1.0, 0.1);
  EXPECT_NEAR(b / 4e-4, 1.0, 0.1);
  EXPECT_NEAR(ab / 4e-4, 0.0, 0.07);
}

TEST(Conditioner, CalibrationOfTheChannelIsUndoneByToSi) {
  VehicleConfig vehicle = test::reference_vehicle();
  vehicle.node[0].channel[2].scale_m_s2_per_count = 3.1e-5;
  vehicle.node[0].channel[2].offset_counts = -1234.0;
  SourceVector sources = SourceVector::Zero();
  sources(kBodyCoordinates) = -7.5;
  const auto scans = convert(test::ideal_scenario(30.0), vehicle, 2000, [&](double) { return sources; });
  EXPECT_EQ(scans.back().counts[2], std::lround(-7.5 / 3.1e-5 - 1234.0));
  EXPECT_NEAR(vehicle.node[0].channel[2].to_si(scans.back().counts[2]), -7.5, 3.1e-5);
}

TEST(Conditioner, FlagsAndClipsWhatLeavesTheRangeEvenBetweenConversions) {
  const VehicleConfig vehicle = test::reference_vehicle();
  const auto scans = convert(test::ideal_scenario(30.0), vehicle, 1000, [&](double t) {
    SourceVector sources = SourceVector::Zero();
    const auto step = std::lround(t / kStep_s);
    if (step == 101) sources(kBodyCoordinates) = 201.0;      // one odd step: no conversion sees its peak
    if (step >= 1000) sources(kBodyCoordinates + 1) = -1e4;  // front right, for good
    return sources;
  });
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const std::uint32_t expected = (k == 51 ? 1U << 2 : 0U) | (k >= 500 ? 1U << 5 : 0U);
    EXPECT_EQ(scans[k].overload, expected) << k;
  }
  EXPECT_NEAR(vehicle.node[0].channel[5].to_si(scans.back().counts[5]), -200.0, 1e-3);
}

/// Amplitude of the front left carrier's vertical channel under 3 m/s^2 of it.
Complex answer(const Scenario& scenario, double frequency_hz, std::size_t channel = 2) {
  const VehicleConfig vehicle = test::reference_vehicle();
  const auto scans = convert(scenario, vehicle, 6000, [&](double t) {
    SourceVector sources = SourceVector::Zero();
    sources(kBodyCoordinates) = 3.0 * std::cos(2.0 * kPi * frequency_hz * t);
    return sources;
  });
  Complex sum = 0.0;
  for (std::size_t k = 4000; k < 6000; ++k)
    sum += vehicle.node[0].channel[channel].to_si(scans[k].counts[channel]) *
           std::polar(2.0 / 2000.0, -2.0 * kPi * frequency_hz * static_cast<double>(k) / 2000.0);
  return sum / 3.0;
}

TEST(Conditioner, ABracketResonates) {
  Scenario scenario = test::ideal_scenario(30.0);
  const Complex rigid = answer(scenario, 100.0);
  scenario.sensor.bracket_hz = {100.0, 100.0};
  scenario.sensor.bracket_damping = 0.05;
  // (1 + 2 D j) / (2 D j) at resonance; straight lines between the steps multiply by sinc^2 (pi f step): 0.2
  // %.
  const Complex expected = Complex(1.0, 0.1) / Complex(0.0, 0.1);
  EXPECT_LT(std::abs(answer(scenario, 100.0) / rigid - expected), 0.01 * std::abs(expected));
  // Far below it nothing but (f / f0)^2 more.
  EXPECT_NEAR(std::abs(answer(scenario, 5.0) / answer(test::ideal_scenario(30.0), 5.0)), 1.0025, 1e-4);
}

TEST(Conditioner, GainsAndTiltsLieWithinWhatIsSaidAndDiffer) {
  Scenario scenario = test::ideal_scenario(30.0);
  const Complex exact = answer(scenario, 10.0);
  scenario.sensor.gain = 0.03;
  const Complex gained = answer(scenario, 10.0) / exact;
  EXPECT_NEAR(gained.imag(), 0.0, 1e-5);
  EXPECT_NE(gained.real(), 1.0);
  EXPECT_NEAR(gained.real(), 1.0, 0.03);
  scenario.sensor.gain = 0.0;
  scenario.sensor.tilt_rad = 0.05;
  const Complex up = answer(scenario, 10.0) / exact;
  EXPECT_LT(up.real(), 1.0);
  EXPECT_GE(up.real(), std::cos(0.05) - 1e-5);
  // The horizontal ones feel up to the sine of their tilt.
  const double forward = std::abs(answer(scenario, 10.0, 0) / exact);
  const double left = std::abs(answer(scenario, 10.0, 1) / exact);
  EXPECT_GT(forward, 1e-4);
  EXPECT_LT(forward, std::sin(0.05));
  EXPECT_GT(left, 1e-4);
  EXPECT_LT(left, std::sin(0.05));
}

TEST(Conditioner, AFilterOfInexactComponentsIsNearlyTheDeclaredOne) {
  Scenario scenario = test::ideal_scenario(30.0);
  const Complex at_rest = answer(scenario, 1.0), exact = answer(scenario, 18.0),
                corner = answer(scenario, 200.0);
  scenario.sensor.filter = 0.03;
  EXPECT_LT(std::abs(answer(scenario, 1.0) / at_rest - 1.0), 3e-3);
  // The phase of a Butterworth filter of order 6 is 3.86 f / fc there; three corners off by up to 3 % and
  // their dampings by as much change it by up to 2 * 3 % of that.
  const double phase = std::abs(std::arg(answer(scenario, 18.0) / exact));
  EXPECT_GT(phase, 1e-5);
  EXPECT_LT(phase, 0.06 * 3.86 * 18.0 / 200.0);
  EXPECT_NEAR(std::abs(answer(scenario, 200.0) / corner), 1.0, 0.25);
}

TEST(Conditioner, ClipsBelowItsRangeWithoutAFlag) {
  Scenario scenario = test::ideal_scenario(30.0);
  scenario.sensor.clips_at = 0.5;
  const VehicleConfig vehicle = test::reference_vehicle();
  const auto scans = convert(scenario, vehicle, 1000, [&](double) {
    SourceVector sources = SourceVector::Zero();
    sources(kBodyCoordinates) = 150.0;
    return sources;
  });
  for (const Scan& scan : scans) EXPECT_EQ(scan.overload, 0U);
  EXPECT_NEAR(vehicle.node[0].channel[2].to_si(scans.back().counts[2]), 100.0, 1e-3);
}

TEST(Conditioner, RoadChannelCarriesTheRoadUnderItsWheelAndUnusedChannelsNothing) {
  VehicleConfig vehicle = test::reference_vehicle();
  Scenario scenario = test::ideal_scenario(30.0);
  scenario.sensor.noise_m_s2 = 0.02;
  vehicle.node[0].channel[1].role = ChannelRole::kRoad;
  vehicle.node[0].channel[1].mount = "rear_left";
  vehicle.node[0].channel[0].role = ChannelRole::kUnused;
  SourceVector sources = SourceVector::Zero();
  sources(kRoadSource + 2) = 0.012;
  const auto scans = convert(scenario, vehicle, 2000, [&](double) { return sources; });
  EXPECT_NEAR(vehicle.node[0].channel[1].to_si(scans.back().counts[1]), 0.012, 2.4e-5);
  EXPECT_EQ(scans.back().counts[0], 0);
}

}  // namespace
}  // namespace roadbalance::sim
