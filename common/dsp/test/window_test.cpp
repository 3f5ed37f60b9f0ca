#include "common/dsp/window.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

/// Gain of the window for a sine that lies `offset` bins beside the bin looked at, 1 in the middle.
double gain(const std::vector<double>& w, double offset) {
  std::complex<double> sum = 0.0;
  for (std::size_t n = 0; n < w.size(); ++n)
    sum += w[n] * std::polar(1.0, 2.0 * std::numbers::pi * offset * static_cast<double>(n) /
                                      static_cast<double>(w.size()));
  return std::abs(sum) / std::accumulate(w.begin(), w.end(), 0.0);
}

TEST(Window, HannIsASquaredSine) {
  const auto w = window(Window::kHann, 100);
  for (std::size_t n = 0; n < w.size(); ++n)
    EXPECT_NEAR(w[n], std::pow(std::sin(std::numbers::pi * static_cast<double>(n) / 100.0), 2), 1e-15);
}

TEST(Window, NoiseBandwidthsAreThePublishedOnes) {
  // Heinzel et al. 2002, table of appendix C; sums of squares of the cosine terms, exact from 16 samples on.
  EXPECT_NEAR(equivalent_noise_bandwidth_bins(window(Window::kRectangular, 64)), 1.0, 1e-12);
  EXPECT_NEAR(equivalent_noise_bandwidth_bins(window(Window::kHann, 64)), 1.5, 1e-12);
  EXPECT_NEAR(equivalent_noise_bandwidth_bins(window(Window::kFlatTop, 64)), 3.8112, 5e-5);
}

TEST(Window, FlatTopIsFlatAndItsSideLobesAreLow) {
  const auto w = window(Window::kFlatTop, 4'096);
  for (double offset = 0.0; offset <= 0.5; offset += 0.05)
    EXPECT_LT(std::abs(20.0 * std::log10(gain(w, offset))), 0.00445) << offset;  // published: 0.0044 dB
  for (double offset = 5.0; offset <= 20.0; offset += 0.1)
    EXPECT_LT(20.0 * std::log10(gain(w, offset)), -95.0) << offset;  // published: -95.0 dB, aliases left out
}

TEST(Window, SineOnABinStaysWithinTheWindowsBins) {
  const auto hann = window(Window::kHann, 64);
  EXPECT_NEAR(gain(hann, 1.0), 0.5, 1e-12);
  for (int bin = 2; bin < 32; ++bin) EXPECT_LT(gain(hann, bin), 1e-14) << bin;
  const auto flat = window(Window::kFlatTop, 64);
  for (int bin = 5; bin < 32; ++bin) EXPECT_LT(gain(flat, bin), 1e-14) << bin;
}

TEST(Window, RefusesASizeThatIsNone) {
  EXPECT_THROW(window(Window::kHann, 0), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
