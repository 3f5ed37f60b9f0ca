#include "tools/report/spectrum_chart.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "common/dsp/cross_spectra.hpp"

namespace roadbalance {
namespace {

constexpr double kRate_hz = 1000.0;
constexpr int kSegment = 4000;

CrossSpectra spectra_of(int samples, double sine_hz, double amplitude, unsigned seed) {
  CrossSpectra spectra({.welch = {.rate_hz = kRate_hz, .segment = kSegment}, .channels = 1});
  std::mt19937 random(seed);
  std::normal_distribution<double> noise;
  Eigen::MatrixXd signal(1, samples);
  for (int k = 0; k < samples; ++k)
    signal(0, k) = noise(random) + amplitude * std::sin(2.0 * M_PI * sine_hz * k / kRate_hz);
  spectra.add(signal);
  return spectra;
}

TEST(SpectrumPeaks, NoiseHasNoneHoweverFewItsAverages) {
  for (unsigned seed = 1; seed <= 50; ++seed)
    for (const int segments : {1, 2, 4, 10, 40}) {
      const CrossSpectra noise = spectra_of(segments * kSegment, 0.0, 0.0, seed);
      EXPECT_TRUE(spectrum_peaks(noise.density(0), 2, noise.independent_averages(), 3).empty())
          << segments << " segments, seed " << seed;
    }
}

TEST(SpectrumPeaks, ASineIsTheHighestAtItsFrequency) {
  const CrossSpectra both = spectra_of(40 * kSegment, 123.25, 0.5, 7);
  const auto peaks = spectrum_peaks(both.density(0), 2, both.independent_averages(), 3);
  ASSERT_EQ(peaks.size(), 1U);
  EXPECT_DOUBLE_EQ(static_cast<double>(peaks[0].bin) * both.step_hz(), 123.25);
  // The density is 2 / rate for the noise and A^2 / 2 / (1.5 step) for the sine, by the window's bandwidth.
  const double expected = (0.125 / (1.5 * both.step_hz()) + 2.0 / kRate_hz) / (2.0 / kRate_hz);
  EXPECT_GT(peaks[0].prominence, expected * 0.8);
}

TEST(SpectrumPeaks, ProminenceIsCountedToTheHigherOfTheTwoValleys) {
  //                                0  1    2  3     4   5    6
  const std::vector<double> density{1, 100, 2, 1000, 10, 500, 1};
  const auto peaks = spectrum_peaks(density, 0, 1e9, 10);
  ASSERT_EQ(peaks.size(), 3U);
  EXPECT_EQ(peaks[0].bin, 3U);
  EXPECT_DOUBLE_EQ(peaks[0].prominence, 1000.0);
  EXPECT_EQ(peaks[1].bin, 5U);
  EXPECT_DOUBLE_EQ(peaks[1].prominence, 50.0);
  EXPECT_EQ(peaks[2].bin, 1U);
  EXPECT_DOUBLE_EQ(peaks[2].prominence, 50.0);
  EXPECT_EQ(spectrum_peaks(density, 0, 1e9, 1).size(), 1U);
}

TEST(SpectrumChart, MarksTheSineAndDrawsNoMorePointsThanItHasWidth) {
  const CrossSpectra both = spectra_of(40 * kSegment, 123.25, 0.5, 7);
  const std::string svg = spectrum_chart(both.density(0), both.step_hz(), both.independent_averages());
  EXPECT_NE(svg.find(">123.25 Hz</text>"), std::string::npos) << svg;
  EXPECT_LT(svg.size(), 12'000U);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(SpectrumChart, SaysThatThereIsNothingToDraw) {
  EXPECT_NE(spectrum_chart(std::vector<double>(2001, 0.0), 0.25, 10).find("nothing but zero"),
            std::string::npos);
  EXPECT_NE(spectrum_chart({}, 0.25, 10).find("</svg>"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
