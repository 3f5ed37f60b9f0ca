#include "common/dsp/psd.hpp"

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "common/test/no_allocation.hpp"

namespace roadbalance {
namespace {

constexpr double kRateHz = 2'000.0;
constexpr int kSegment = 400;

std::vector<double> sine(double amplitude, double frequency_hz, int size) {
  std::vector<double> x(static_cast<std::size_t>(size));
  for (std::size_t n = 0; n < x.size(); ++n)
    x[n] =
        amplitude * std::cos(2.0 * std::numbers::pi * frequency_hz * static_cast<double>(n) / kRateHz + 0.3);
  return x;
}

std::vector<double> noise(double sigma, int size) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, sigma);
  std::vector<double> x(static_cast<std::size_t>(size));
  for (double& sample : x) sample = normal(random);
  return x;
}

double integral(const WelchPsd& psd) {
  const auto density = psd.density();
  return psd.step_hz() * std::accumulate(density.begin(), density.end(), 0.0);
}

TEST(WelchPsd, SineShowsHalfItsSquaredAmplitudeInEveryWindow) {
  for (const Window kind : {Window::kRectangular, Window::kHann, Window::kFlatTop}) {
    WelchPsd psd({.rate_hz = kRateHz, .segment = kSegment, .window = kind});
    psd.add(sine(3.0, 100.0, 2'000));
    const auto bin = static_cast<std::size_t>(std::lround(100.0 / psd.step_hz()));
    EXPECT_NEAR(psd.density()[bin] * psd.enbw_hz(), 4.5, 1e-10);
    EXPECT_NEAR(integral(psd), 4.5, 1e-10);  // Parseval
  }
}

TEST(WelchPsd, ConstantAndHighestFrequencyAreNotDoubled) {
  WelchPsd psd({.rate_hz = kRateHz, .segment = kSegment, .window = Window::kRectangular});
  std::vector<double> x(1'000);
  for (std::size_t n = 0; n < x.size(); ++n) x[n] = 2.0 + (n % 2 == 0 ? 3.0 : -3.0);
  psd.add(x);
  EXPECT_NEAR(psd.density().front() * psd.step_hz(), 4.0, 1e-10);
  EXPECT_NEAR(psd.density().back() * psd.step_hz(), 9.0, 1e-10);
}

TEST(WelchPsd, WhiteNoiseHasItsLevelWithinTheTheoreticalConfidence) {
  const double sigma = 0.7;
  WelchPsd psd({.rate_hz = kRateHz, .segment = kSegment});
  psd.add(noise(sigma, kSegment / 2 * 401));
  ASSERT_EQ(psd.averages(), 400);
  const double level = 2.0 * sigma * sigma / kRateHz;
  // Welch 1967: each bin scatters by 1 / sqrt(averages), segments of half overlap under a Hann window being
  // correlated by 1/6: (1 + 2 / 36).
  const double scatter = std::sqrt((1.0 + 2.0 / 36.0) / psd.averages());
  const auto density = psd.density();
  double mean = 0.0;
  int far = 0;
  for (std::size_t k = 1; k + 1 < density.size(); ++k) {
    mean += density[k] / level / static_cast<double>(density.size() - 2);
    if (std::abs(density[k] / level - 1.0) > 2.0 * scatter) ++far;
    EXPECT_LT(std::abs(density[k] / level - 1.0), 5.0 * scatter) << k;
  }
  // Two sigma leave out 4.6 % of the 199 bins; the mean square of all samples scatters by sqrt(2 / samples).
  EXPECT_GE(far, 2);
  EXPECT_LE(far, 20);
  EXPECT_NEAR(mean, 1.0, 4.0 * std::sqrt(2.0 / (kSegment / 2 * 401)));
}

TEST(WelchPsd, DoesNotDependOnHowTheSamplesCome) {
  const auto x = noise(1.0, 3'000);
  const WelchPsd::Settings settings{.rate_hz = kRateHz, .segment = 256, .overlap = 0.75};
  WelchPsd whole(settings);
  whole.add(x);
  WelchPsd pieces(settings);
  for (std::size_t n = 0; n < x.size(); n += 20) pieces.add(std::span(x).subspan(n, 20));
  EXPECT_EQ(whole.averages(), 1 + (3'000 - 256) / 64);
  EXPECT_EQ(whole.averages(), pieces.averages());
  EXPECT_EQ(whole.density(), pieces.density());
}

TEST(WelchPsd, ResetForgetsEverything) {
  WelchPsd psd({.rate_hz = kRateHz, .segment = kSegment});
  psd.add(noise(100.0, 1'111));
  psd.reset();
  EXPECT_EQ(psd.averages(), 0);
  for (const double d : psd.density()) EXPECT_EQ(d, 0.0);
  psd.add(sine(1.0, 50.0, kSegment));
  EXPECT_EQ(psd.averages(), 1);
  EXPECT_NEAR(integral(psd), 0.5, 1e-10);
}

TEST(WelchPsd, AddNeverAllocates) {
  WelchPsd psd({.rate_hz = kRateHz, .segment = kSegment});
  const auto x = noise(1.0, 2'000);
  const test::NoAllocation guard;
  psd.add(x);
}

TEST(WelchPsd, RefusesImpossibleSettings) {
  EXPECT_THROW(WelchPsd({.rate_hz = 0.0, .segment = 64}), std::invalid_argument);
  EXPECT_THROW(WelchPsd({.rate_hz = 1.0, .segment = 1}), std::invalid_argument);
  EXPECT_THROW(WelchPsd({.rate_hz = 1.0, .segment = 64, .overlap = 1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
