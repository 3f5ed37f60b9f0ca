#include "sim/road.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace roadbalance::sim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr RoadScenario kClassA{16e-6, 0.3, 0.95};
constexpr std::array<double, 6> kWaveNumbers_1_m{0.1, 0.25, 0.5, 1.0, 2.0, 5.0};

/// Two-sided density of the height, from the formula of the sheet: |w2 / ((s+w1)(s+w2))|^2 2 pi^2 n0^2 Gd.
double analytic_density(double wave_number_1_m) {
  const double w = 2.0 * kPi * wave_number_1_m, w1 = 2.0 * kPi * 0.01, w2 = 2.0 * kPi * 4.0;
  return w2 * w2 / ((w * w + w1 * w1) * (w * w + w2 * w2)) * 2.0 * kPi * kPi * 0.01 * 16e-6;
}

/// Averaged cross periodograms of two wheels' roads at the same place, sections of 40 m, Hann window, no
/// overlap.
struct CrossSpectrum {
  std::array<double, kWaveNumbers_1_m.size()> first{}, second{};
  std::array<std::complex<double>, kWaveNumbers_1_m.size()> cross{};
};
constexpr int kSections = 250;
constexpr int kSection = 4000;

CrossSpectrum cross_spectrum(std::size_t wheel_a, std::size_t wheel_b,
                             const RoadScenario& scenario = kClassA) {
  RoadProfile a(scenario, 5, wheel_a, 0.0), b(scenario, 5, wheel_b, 0.0);
  std::vector<std::vector<std::complex<double>>> kernel(kWaveNumbers_1_m.size());
  for (std::size_t k = 0; k < kernel.size(); ++k)
    for (int i = 0; i < kSection; ++i) {
      const double hann = std::sqrt(2.0 / 3.0) * (1.0 - std::cos(2.0 * kPi * i / kSection));
      const double place_m = i * RoadFilter::kGrid_m;
      kernel[k].push_back(std::polar(hann, -2.0 * kPi * kWaveNumbers_1_m[k] * place_m));
    }
  CrossSpectrum result;
  const double scale = RoadFilter::kGrid_m / kSection / kSections;
  for (int s = 0; s < kSections; ++s) {
    std::array<std::complex<double>, kWaveNumbers_1_m.size()> sum_a{}, sum_b{};
    for (int i = 0; i < kSection; ++i) {
      const double place_m = RoadFilter::kGrid_m * (static_cast<double>(s) * kSection + i + 0.25);
      const double u = a.at(place_m).height_m, v = b.at(place_m).height_m;
      for (std::size_t k = 0; k < kernel.size(); ++k) {
        sum_a[k] += u * kernel[k][static_cast<std::size_t>(i)];
        sum_b[k] += v * kernel[k][static_cast<std::size_t>(i)];
      }
    }
    for (std::size_t k = 0; k < kernel.size(); ++k) {
      result.first[k] += scale * std::norm(sum_a[k]);
      result.second[k] += scale * std::norm(sum_b[k]);
      result.cross[k] += scale * std::conj(sum_a[k]) * sum_b[k];
    }
  }
  return result;
}

TEST(Road, HasTheSpectrumOfItsClassOnBothSides) {
  const CrossSpectrum spectrum = cross_spectrum(0, 1);
  double mean = 0.0;
  for (std::size_t k = 0; k < kWaveNumbers_1_m.size(); ++k) {
    const double a = spectrum.first[k] / analytic_density(kWaveNumbers_1_m[k]);
    const double b = spectrum.second[k] / analytic_density(kWaveNumbers_1_m[k]);
    // A mean of 250 exponentially distributed periodograms has a standard deviation of 1 / sqrt(250) = 6.3 %.
    EXPECT_NEAR(a, 1.0, 4.5 / std::sqrt(kSections)) << kWaveNumbers_1_m[k];
    EXPECT_NEAR(b, 1.0, 4.5 / std::sqrt(kSections)) << kWaveNumbers_1_m[k];
    mean += (a + b) / (2.0 * kWaveNumbers_1_m.size());
  }
  EXPECT_NEAR(mean, 1.0, 4.5 / std::sqrt(2.0 * kWaveNumbers_1_m.size() * kSections / 1.09));
}

// Exponents of ISO 8608 lie about 2, those of roads between 1.5 and 3.3 (P. Andren, Power spectral density
// approximations of longitudinal road profiles, Int. J. Vehicle Design 40 (2006) 2-14).
TEST(Road, HasTheWavinessOfEachSideUpToTheBendAndBeyond) {
  RoadScenario scenario = kClassA;
  scenario.waviness = {.below = 1.5, .above = 3.0, .bend_1_m = 0.4};
  scenario.right_waviness = 0.5;
  const CrossSpectrum spectrum = cross_spectrum(0, 1, scenario);
  for (std::size_t k = 0; k < kWaveNumbers_1_m.size(); ++k) {
    const double n = kWaveNumbers_1_m[k];
    if (n > 0.2 && n < 0.9) continue;  // the bend is round
    const auto expected = [&](double below, double above) {
      const double at_bend = std::pow(std::min(n, 0.4) / 0.1, 2.0 - below);
      return analytic_density(n) * at_bend * std::pow(std::max(n, 0.4) / 0.4, 2.0 - above);
    };
    // The bend's roundness and the ladder's end leave up to 7 %.
    EXPECT_NEAR(spectrum.first[k] / expected(1.5, 3.0), 1.0, 0.07 + 4.5 / std::sqrt(kSections)) << n;
    // 0.3^2 of the right side is what it shares with the left one, which neither leads.
    const double right = 0.09 * expected(1.5, 3.0) + 0.91 * expected(2.0, 3.5);
    EXPECT_NEAR(spectrum.second[k] / right, 1.0, 0.07 + 4.5 / std::sqrt(kSections)) << n;
    const std::complex<double> gain = spectrum.cross[k] / spectrum.first[k];
    const double own = std::sqrt(0.91 * expected(2.0, 3.5) / expected(1.5, 3.0));
    EXPECT_NEAR(gain.real(), 0.3, 4.5 * own / std::sqrt(2.0 * kSections)) << n;
    EXPECT_NEAR(gain.imag(), 0.0, 4.5 * own / std::sqrt(2.0 * kSections)) << n;
  }
}

TEST(Road, ALadderOfFiltersHasThePowerThatItIsSetTo) {
  WavinessFilter filter(RoadFilter::kGrid_m);
  for (const double waviness : {1.5, 1.7, 2.5, 3.0, 3.3}) {
    filter.set({.below = waviness, .above = waviness}, 3.0);
    for (double n = 0.03; n < 4.0; n *= 1.1)
      EXPECT_NEAR(filter.magnitude(n) / (3.0 * std::pow(n / 0.1, 0.5 * (2.0 - waviness))), 1.0, 0.005) << n;
  }
  filter.set({}, 3.0);
  EXPECT_EQ(filter.magnitude(0.7), 3.0);
  // Bent at n0 itself.
  filter.set({.below = 1.5, .above = 3.0, .bend_1_m = 0.1}, 1.0);
  EXPECT_NEAR(filter.magnitude(0.015) / std::pow(0.15, 0.25), 1.0, 0.03);
  EXPECT_NEAR(filter.magnitude(1.0) / std::pow(10.0, -0.5), 1.0, 0.03);
}

TEST(Road, StretchesDifferInHeightUpToTheFactorAndAreThoseOfTheRearWheelToo) {
  RoadScenario scenario = kClassA;
  scenario.stretch_height = 2.0;
  scenario.stretch_m = 50.0;
  scenario.rear_coherence2 = 1.0;
  RoadProfile front(scenario, 3, 1, 0.0), rear(scenario, 3, 3, 0.0), same({16e-6, 0.3, 1.0}, 3, 1, 0.0);
  double least = 10.0, most = 0.0;
  for (int stretch = 0; stretch < 100; ++stretch) {
    double square = 0.0, of_same = 0.0;
    for (double x = 50.0 * stretch + 1.0; x < 50.0 * stretch + 50.0; x += 0.05) {
      const RoadPoint point = front.at(x);
      square += point.slope * point.slope;
      of_same += std::pow(same.at(x).slope, 2);
      EXPECT_NEAR(rear.at(x).slope, point.slope, 1e-9);
    }
    // The slope remembers 4 cm, so but for the border the ratio is the stretch's factor.
    least = std::min(least, std::sqrt(square / of_same));
    most = std::max(most, std::sqrt(square / of_same));
  }
  EXPECT_GT(least, 0.49);
  EXPECT_LT(least, 0.55);
  EXPECT_GT(most, 1.8);
  EXPECT_LT(most, 2.04);
}

// A flat road with 10 potholes a km in each track and 5 joints across both.
TEST(Road, ObstaclesStandWhereAllWheelsOfTheirTracksMeetThem) {
  RoadScenario scenario{0.0, 0.3, 0.5};
  scenario.pothole = {.per_km = 10.0, .height_m = {0.01, 0.03}};
  scenario.joint = {.per_km = 5.0, .height_m = {0.002, 0.004}};
  RoadProfile left(scenario, 4, 0, 0.0), right(scenario, 4, 1, 0.0), behind(scenario, 4, 2, 0.0);
  int potholes = 0, joints = 0;
  double deepest = 0.0, highest = 0.0;
  bool is_in = false, is_on = false;
  const double h = 1e-4;
  for (double x = 0.0; x < 4000.0; x += 0.013) {
    const RoadPoint point = left.at(x);
    EXPECT_EQ(point.height_m, behind.at(x).height_m);
    EXPECT_NEAR((left.at(x + h).height_m - left.at(x).height_m) / h, left.at(x + 0.5 * h).slope, 2e-4);
    EXPECT_NEAR((left.at(x + h).slope - left.at(x).slope) / h, left.at(x + 0.5 * h).curvature_1_m, 0.7);
    const bool down = point.height_m < -1e-6;
    const bool joint = point.height_m > 1e-6 && right.at(x).height_m > 1e-6;
    potholes += down && !is_in;
    joints += joint && !is_on;
    is_in = down;
    is_on = joint;
    deepest = std::min(deepest, point.height_m);
    highest = std::max(highest, point.height_m);
  }
  EXPECT_EQ(potholes, 40);
  EXPECT_NEAR(joints, 20, 1);  // one may lie in a pothole
  EXPECT_GT(deepest, -0.030);
  EXPECT_LT(deepest, -0.027);
  EXPECT_LE(highest, 0.004);
  EXPECT_GT(highest, 0.0035);
}

/// The regression of b on a, S_ab / S_aa, must be `gain`; each part of its error has the standard deviation
/// sqrt((1 - gain^2) / (2 sections)).
void expect_gain(std::size_t wheel_a, std::size_t wheel_b, double gain) {
  const CrossSpectrum spectrum = cross_spectrum(wheel_a, wheel_b);
  const double tolerance = 4.5 * std::sqrt((1.0 - gain * gain) / (2.0 * kSections));
  for (std::size_t k = 0; k < kWaveNumbers_1_m.size(); ++k) {
    const std::complex<double> measured = spectrum.cross[k] / spectrum.first[k];
    EXPECT_NEAR(measured.real(), gain, tolerance) << kWaveNumbers_1_m[k];
    EXPECT_NEAR(measured.imag(), 0.0, tolerance) << kWaveNumbers_1_m[k];
  }
}

TEST(Road, LeftAndRightCorrelateOnBothAxles) {
  expect_gain(0, 1, 0.3);
  expect_gain(2, 3, 0.3);
}

TEST(Road, RearTrackHasTheGivenCoherenceWithTheFrontTrackAtTheSamePlace) {
  expect_gain(0, 2, std::sqrt(0.95));
  expect_gain(1, 3, std::sqrt(0.95));
  expect_gain(0, 3, std::sqrt(0.95) * 0.3);
}

TEST(Road, FullyCoherentRearWheelMeetsTheSameRoad) {
  const RoadScenario scenario{16e-6, 0.3, 1.0};
  RoadProfile front(scenario, 9, 1, 3.0), rear(scenario, 9, 3, -1.0);
  for (double x = 3.0; x < 30.0; x += 0.0037) {
    const RoadPoint a = front.at(x), b = rear.at(x);
    // They began 4 m apart; 200 m at the lower corner (16 m) leave exp(-200/16) = 4e-6 of some centimetres.
    EXPECT_NEAR(a.height_m, b.height_m, 1e-6);
    EXPECT_NEAR(a.slope, b.slope, 1e-7);
  }
}

TEST(Road, SlopeIsTheDerivativeOfHeight) {
  RoadProfile road(kClassA, 2, 0, 0.0), ahead(kClassA, 2, 0, 0.0), behind(kClassA, 2, 0, 0.0);
  const double h = 1e-5;
  for (int i = 0; i < 5000; ++i) {
    const double x = 0.001 + 0.00137 * i;
    const double difference = (ahead.at(x + h).height_m - behind.at(x - h).height_m) / (2.0 * h);
    // The curvature of a cubic jumps at grid points: slope / cell * h, some 1e-2 / 1e-2 * 1e-5.
    EXPECT_NEAR(road.at(x).slope, difference, 1e-4);
  }
}

TEST(Road, NoRoadIsFlat) {
  RoadProfile road({0.0, 0.3, 0.95}, 2, 2, 0.0);
  EXPECT_EQ(road.at(12.345).height_m, 0.0);
  EXPECT_EQ(road.at(12.345).slope, 0.0);
}

}  // namespace
}  // namespace roadbalance::sim
