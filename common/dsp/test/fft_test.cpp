#include "common/dsp/fft.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using Lines = std::vector<std::complex<double>>;

std::vector<double> noise(int size, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> samples(static_cast<std::size_t>(size));
  for (double& sample : samples) sample = normal(random);
  return samples;
}

/// The definition, term by term.
Lines direct(const std::vector<double>& in) {
  const auto size = in.size();
  Lines out(size / 2 + 1);
  for (std::size_t k = 0; k < out.size(); ++k)
    for (std::size_t n = 0; n < size; ++n)
      out[k] += in[n] * std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(k * n % size) /
                                            static_cast<double>(size));
  return out;
}

Lines fast(RealFft& fft, const std::vector<double>& in) {
  Lines out(static_cast<std::size_t>(fft.bins()));
  fft.forward(in, out);
  return out;
}

TEST(RealFft, EqualsTheDirectSumAtEvenOddAndPrimeSizes) {
  for (const int size : {2, 3, 4, 6, 8, 10, 15, 16, 32, 34, 36, 96, 97, 160, 250, 256}) {
    RealFft fft(size);
    const auto in = noise(size, static_cast<unsigned>(size));
    const Lines expected = direct(in);
    const Lines lines = fast(fft, in);
    ASSERT_EQ(lines.size(), expected.size()) << size;
    // Rounding of the direct sum grows like the size times 1e-16.
    for (std::size_t k = 0; k < lines.size(); ++k)
      EXPECT_LT(std::abs(lines[k] - expected[k]), 1e-14 * size) << size << ", bin " << k;
  }
}

TEST(RealFft, GivesRealAndImaginaryPartsOfEightBinsApartAsItGivesThemTogether) {
  for (const int size : {2, 3, 6, 15, 16, 32, 34, 48, 64, 96, 250, 256, 4096}) {
    RealFft fft(size);
    const auto samples = noise(size, static_cast<unsigned>(size));
    std::copy(samples.begin(), samples.end(), fft.input().begin());
    std::vector<BinLane> lanes(2 * ((static_cast<std::size_t>(fft.bins()) + 7) / 8));
    fft.transform(fft.input(), lanes);
    const auto lines = fft.transform();
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const std::complex<double> line(lanes[k / 8 * 2].of[k % 8], lanes[k / 8 * 2 + 1].of[k % 8]);
      EXPECT_LT(std::abs(line - lines[k]), 1e-15 * size) << size << ", bin " << k;
    }
    EXPECT_EQ(lanes[1].of[0], 0.0) << size;  // the mean is real
    for (std::size_t k = lines.size(); k < 4 * lanes.size(); ++k) {
      EXPECT_EQ(lanes[k / 8 * 2].of[k % 8], 0.0) << size << ", bin " << k;
      EXPECT_EQ(lanes[k / 8 * 2 + 1].of[k % 8], 0.0) << size << ", bin " << k;
    }
  }
}

TEST(RealFft, GivesTheSameBitsAgainAndInAnotherObject) {
  const auto in = noise(1'000, 7);
  RealFft one(1'000);
  RealFft other(1'000);
  const Lines first = fast(one, in);
  EXPECT_EQ(first, fast(one, in));
  EXPECT_EQ(first, fast(other, in));
}

TEST(RealFft, PlansAndRunsInSeveralThreads) {
  std::vector<Lines> result(4);
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < result.size(); ++t)
      threads.emplace_back([&result, t] {
        for (int size = 64; size <= 128; ++size) {
          RealFft fft(size);
          result[t] = fast(fft, noise(size, 1));
        }
      });
  }
  for (const Lines& lines : result) EXPECT_EQ(lines, result.front());
}

TEST(RealFft, RefusesASizeThatIsNone) {
  EXPECT_THROW(RealFft(1), std::invalid_argument);
  EXPECT_THROW(RealFft(-8), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
