#include "common/dsp/cross_spectra.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "common/dsp/transfer_function.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

/// As spectra_with_scipy.py makes them.
Eigen::MatrixXd scipy_signals() {
  constexpr Eigen::Index kSamples = 3000;
  const auto noise = [&](std::int64_t state) {
    Eigen::RowVectorXd values(kSamples);
    for (double& value : values) {
      state = state * 48271 % 2147483647;
      value = static_cast<double>(state) / 2147483647.0 - 0.5;
    }
    return values;
  };
  const Eigen::RowVectorXd first = noise(1), second = noise(2), third = noise(3);
  Eigen::MatrixXd x(3, kSamples);
  double last = 0.0, before = 0.0;
  for (Eigen::Index n = 0; n < kSamples; ++n) {
    const double now = first(n) + 1.2 * last - 0.7 * before;
    x.col(n) << first(n), now + 0.3 * third(n), second(n);
    before = std::exchange(last, now);
  }
  return x;
}

Eigen::MatrixXd white(int channels, Eigen::Index samples, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(channels, samples, [&] { return normal(random); });
}

Window named(const std::string& name) {
  return name == "hann" ? Window::kHann : name == "flat_top" ? Window::kFlatTop : Window::kRectangular;
}

TEST(CrossSpectra, AgreeWithSciPy) {
  const Eigen::MatrixXd x = scipy_signals();
  const Json data = Json::parse(test::read_source("common/dsp/test/data/spectra_scipy.json"));
  for (const Json& of : data["cases"]) {
    CrossSpectra spectra({.welch = {.rate_hz = 1000.0,
                                    .segment = of["segment"],
                                    .overlap = of["overlap"],
                                    .window = named(of["window"])},
                          .channels = 3});
    for (Eigen::Index n = 0; n < x.cols(); n += 77)  // in pieces that fit nothing
      spectra.add(x.middleCols(n, std::min<Eigen::Index>(77, x.cols() - n)));
    for (int a = 0; a < 3; ++a) {
      const auto density = spectra.density(a);
      const auto& expected = of["density"][static_cast<std::size_t>(a)];
      ASSERT_EQ(density.size(), expected.size());
      const double most = *std::max_element(density.begin(), density.end());
      for (std::size_t k = 0; k < density.size(); ++k)
        ASSERT_NEAR(density[k], expected[k].get<double>(), 1e-12 * most) << of["window"] << a << k;
    }
    for (std::size_t p = 0; p < of["cross"].size(); ++p) {
      const Json& pair = of["cross"][p];
      const int a = pair["a"], b = pair["b"];
      const auto cross = spectra.density(a, b), turned = spectra.density(b, a);
      const TransferFunction h =
          transfer_function(spectra.density(a), spectra.density(b), cross, spectra.independent_averages());
      for (std::size_t k = 0; k < cross.size(); ++k) {
        const std::complex<double> expected(pair["re"][k], pair["im"][k]);
        ASSERT_LT(std::abs(cross[k] - expected), 1e-15) << of["window"] << a << b << k;
        ASSERT_EQ(turned[k], std::conj(cross[k]));
        ASSERT_NEAR(h.coherence[k], of["coherence"][p][k].get<double>(), 1e-9);
      }
    }
  }
}

TEST(CrossSpectra, TellsEachPairAsIfItWereAlone) {
  // Seventeen channels, so that neither lanes nor triangle are full: each pair as if it were alone.
  const Eigen::MatrixXd x = white(17, 2000, 3);
  const WelchPsd::Settings welch{.rate_hz = 100.0, .segment = 90};
  CrossSpectra all({.welch = welch, .channels = 17});
  all.add(x);
  for (const auto& [a, b] : {std::pair{0, 16}, {7, 9}, {15, 16}}) {
    CrossSpectra two({.welch = welch, .channels = 2});
    Eigen::MatrixXd pair(2, x.cols());
    pair << x.row(a), x.row(b);
    two.add(pair);
    const auto one = all.density(a, b), other = two.density(0, 1);
    for (std::size_t k = 0; k < one.size(); ++k) EXPECT_LT(std::abs(one[k] - other[k]), 1e-14);
  }
}

TEST(CrossSpectra, ASegmentAcrossAGapIsNotTakenAndNothingElseIsLost) {
  const Eigen::MatrixXd x = white(2, 1000, 7);
  const WelchPsd::Settings welch{.rate_hz = 100.0, .segment = 100, .overlap = 0.0};
  CrossSpectra whole({.welch = welch, .channels = 2}), cut({.welch = welch, .channels = 2});
  whole.add(x.leftCols(300));
  whole.add(x.rightCols(300));
  cut.add(x.leftCols(350));  // the last 50 have no end
  cut.gap();
  cut.add(x.rightCols(300));
  EXPECT_EQ(cut.averages(), 6);
  EXPECT_EQ(cut.density(0, 1), whole.density(0, 1));
}

TEST(CrossSpectra, AnExponentialAverageForgetsAsItSays) {
  // A segment of ones, then of zeros: after m of them (1 - 1/memory)^m is left.
  constexpr int kMemory = 5;
  CrossSpectra spectra(
      {.welch = {.rate_hz = 64.0, .segment = 64, .overlap = 0.0, .window = Window::kRectangular},
       .channels = 1,
       .memory = kMemory,
       .hold_peaks = true});
  for (int n = 0; n < 20; ++n) spectra.add(Eigen::MatrixXd::Ones(1, 64));
  EXPECT_NEAR(spectra.density(0)[0], 1.0, 1e-12);
  for (int m = 1; m <= 13; ++m) {
    spectra.add(Eigen::MatrixXd::Zero(1, 64));
    if (m % 3 == 0) {
      EXPECT_NEAR(spectra.density(0)[0], std::pow(1.0 - 1.0 / kMemory, m), 1e-12) << m;
    }
  }
  EXPECT_NEAR(spectra.peak_density(0)[0], 1.0, 1e-12);
  // sum of a_i^2 with a_i = (1 - q) q^i is (1 - q) / (1 + q).
  EXPECT_NEAR(spectra.independent_averages(), 2.0 * kMemory - 1.0, 0.05);
}

TEST(CrossSpectra, AnExponentialAverageIsWorthNoMoreThanItsWeightsSay) {
  // Against the weights themselves, one after the other, before and long after the memory is full.
  constexpr int kMemory = 6;
  const std::vector<double> hann = window(Window::kHann, 64);
  double common = 0.0, power = 0.0;
  for (std::size_t n = 0; n < 64; ++n) power += hann[n] * hann[n];
  for (std::size_t n = 0; n < 32; ++n) common += hann[n] * hann[n + 32];
  const double overlap = common * common / (power * power);  // half over half
  CrossSpectra spectra({.welch = {.rate_hz = 64.0, .segment = 64}, .channels = 1, .memory = kMemory});
  spectra.add(Eigen::MatrixXd::Ones(1, 32));
  std::vector<double> weight;
  for (int m = 1; m <= 40; ++m) {
    spectra.add(Eigen::MatrixXd::Ones(1, 32));
    const double share = 1.0 / std::min(m, kMemory);
    for (double& w : weight) w *= 1.0 - share;
    weight.push_back(share);
    double variance = 0.0;
    for (std::size_t i = 0; i < weight.size(); ++i) {
      variance += weight[i] * weight[i];
      if (i > 0) variance += 2.0 * overlap * weight[i] * weight[i - 1];
    }
    EXPECT_NEAR(spectra.independent_averages() * variance, 1.0, 1e-12) << m;
  }
}

TEST(CrossSpectra, TellsHowManyAveragesItsScatterIsWorth) {
  // Variance of a density over its squared mean is one over the number of independent averages.
  for (const double overlap : {0.0, 0.5, 0.75}) {
    double scatter = 0.0, count = 0.0, independent = 0.0;
    for (unsigned seed = 0; seed < 60; ++seed) {
      CrossSpectra spectra({.welch = {.rate_hz = 1.0, .segment = 128, .overlap = overlap}, .channels = 1});
      spectra.add(white(1, 2560, 100 + seed));
      const auto density = spectra.density(0);
      for (std::size_t k = 2; k + 2 < density.size(); ++k) {
        scatter += std::pow(density[k] / 2.0 - 1.0, 2);  // white noise of variance 1 at 1 Hz: 2 one-sided
        count += 1.0;
      }
      independent = spectra.independent_averages();
    }
    EXPECT_NEAR(scatter / count * independent, 1.0, 0.08) << overlap;  // 3660 bins, neighbours go together
  }
}

TEST(TransferFunction, KnownSignalToNoiseHasItsCoherenceAndGainWithinTheStatedLimits) {
  // y = 3 x + v with var(v) = 9: coherence 1/2, |H| = 3.
  constexpr int kRuns = 40;
  int inside = 0, bins = 0;
  double coherence = 0.0, coherence_squares = 0.0, sigma = 0.0, hv = 0.0;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    Eigen::MatrixXd x = white(2, 64 * 200, 500 + seed);
    x.row(1) = 3.0 * x.row(0) + 3.0 * x.row(1);
    CrossSpectra spectra(
        {.welch = {.rate_hz = 1.0, .segment = 64, .overlap = 0.0, .window = Window::kRectangular},
         .channels = 2});
    spectra.add(x);
    const TransferFunction h = transfer_function(spectra.density(0), spectra.density(1),
                                                 spectra.density(0, 1), spectra.independent_averages());
    for (std::size_t k = 1; k < 32; ++k) {
      inside += std::abs(h.h1[k] - 3.0) < h.radius_95[k] ? 1 : 0;
      coherence += h.coherence[k];
      coherence_squares += h.coherence[k] * h.coherence[k];
      sigma += h.coherence_sigma[k];
      hv += std::abs(h.hv[k]);
      EXPECT_LE(std::abs(h.h1[k]), std::abs(h.hv[k]));
      EXPECT_LE(std::abs(h.hv[k]), std::abs(h.h2[k]) * (1.0 + 1e-12));
      ++bins;
    }
  }
  const double mean = coherence / bins;
  EXPECT_NEAR(static_cast<double>(inside) / bins, 0.95, 4.0 * std::sqrt(0.95 * 0.05 / bins));
  EXPECT_NEAR(mean, 0.5, 0.005);  // its bias is (1 - gamma^2)^2 / n = 0.00125
  EXPECT_NEAR(std::sqrt(coherence_squares / bins - mean * mean) / (sigma / bins), 1.0, 0.08);
  EXPECT_NEAR(hv / bins, std::sqrt(18.0), 0.02);  // sqrt(Gyy / Gxx)
}

TEST(TransferFunction, UnrelatedSignalsStayBelowTheChanceItStatesIn95OfAHundredBins) {
  int below = 0, bins = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    CrossSpectra spectra(
        {.welch = {.rate_hz = 1.0, .segment = 64, .overlap = 0.0, .window = Window::kRectangular},
         .channels = 2});
    spectra.add(white(2, 64 * 20, 900 + seed));
    const TransferFunction h = transfer_function(spectra.density(0), spectra.density(1),
                                                 spectra.density(0, 1), spectra.independent_averages());
    for (std::size_t k = 1; k < 32; ++k, ++bins) below += h.coherence[k] < h.coherence_by_chance ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(below) / bins, 0.95, 4.0 * std::sqrt(0.95 * 0.05 / bins));
}

TEST(TransferFunction, OneAverageTellsNothingAndSilenceIsNoDivisionByZero) {
  const std::vector<double> one{1.0, 0.0}, other{4.0, 0.0};
  const std::vector<std::complex<double>> cross{2.0, 0.0};
  const TransferFunction h = transfer_function(one, other, cross, 1.0);
  EXPECT_EQ(h.coherence_by_chance, 1.0);
  EXPECT_TRUE(std::isinf(h.radius_95[0]));
  EXPECT_EQ(h.h1[0], 2.0);
  EXPECT_EQ(h.h1[1], 0.0);
  EXPECT_EQ(h.coherence[1], 0.0);
  EXPECT_THROW(transfer_function(one, other, std::span(cross).first(1), 1.0), std::invalid_argument);
}

TEST(TransferFunction, AHammeredStructureRingsWhereItsMeasurersFoundIt) {
  static_assert(std::endian::native == std::endian::little);
  constexpr Eigen::Index kSamples = 25'600;  // a second: bins of 1 Hz
  const std::string bytes = test::read_source("common/dsp/test/data/hammer_hits.f32");
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  ASSERT_EQ(values.size(), 5U * 2 * kSamples);
  const auto settings = [] {
    return CrossSpectra::Settings{
        .welch = {.rate_hz = 25'600.0, .segment = kSamples, .overlap = 0.0, .window = Window::kRectangular},
        .channels = 2};
  };
  CrossSpectra all(settings());
  for (std::size_t hit = 0; hit < 5; ++hit) {
    const Eigen::Map<const Eigen::Matrix<float, 2, Eigen::Dynamic, Eigen::RowMajor>> samples(
        &values[hit * 2 * kSamples], 2, kSamples);
    CrossSpectra one(settings());
    one.add(samples.cast<double>());
    all.add(samples.cast<double>());
    const TransferFunction h =
        transfer_function(one.density(0), one.density(1), one.density(0, 1), one.independent_averages());
    for (const int peak_hz : {900, 2640, 3669, 4128}) {
      const auto smaller = [&](int a, int b) {
        return std::abs(h.h1[static_cast<std::size_t>(a)]) < std::abs(h.h1[static_cast<std::size_t>(b)]);
      };
      int found = peak_hz - 40;
      for (int k = found; k <= peak_hz + 40; ++k)
        if (smaller(found, k)) found = k;
      EXPECT_NEAR(found, peak_hz, 1) << hit;
    }
  }
  EXPECT_EQ(all.averages(), 5);
  TransferFunction h =
      transfer_function(all.density(0), all.density(1), all.density(0, 1), all.independent_averages());
  const auto band = std::span(h.coherence).subspan(100, 2901);
  std::nth_element(band.begin(), band.begin() + 1450, band.end());
  EXPECT_NEAR(band[1450], 0.9993, 1e-4);
}

TEST(CrossSpectra, TellsNoLessThanTheMemoryOfItsSumsAndWaitingSegments) {
  // Complex numbers of 16 bytes: 24 channels have 300 pairs, and some segments of each wait.
  EXPECT_GE(CrossSpectra::bytes(24, 4096), 16U * 2049U * (300U + kSegmentsOfBatch * 24U));
  EXPECT_LE(CrossSpectra::bytes(24, 4096), 16U * 2049U * (300U + kSegmentsOfBatch * 24U) * 11U / 10U);
}

TEST(CrossSpectra, RefusesWhatMakesNoSense) {
  const WelchPsd::Settings good{.rate_hz = 1.0, .segment = 8};
  EXPECT_THROW(CrossSpectra({.welch = good, .channels = 0}), std::invalid_argument);
  EXPECT_THROW(CrossSpectra({.welch = {.rate_hz = 0.0, .segment = 8}, .channels = 1}), std::invalid_argument);
  EXPECT_THROW(CrossSpectra({.welch = {.rate_hz = 1.0, .segment = 1}, .channels = 1}), std::invalid_argument);
  EXPECT_THROW(CrossSpectra({.welch = good, .channels = 1, .memory = -1}), std::invalid_argument);
  CrossSpectra two({.welch = good, .channels = 2});
  EXPECT_THROW(two.add(Eigen::MatrixXd::Zero(3, 8)), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
