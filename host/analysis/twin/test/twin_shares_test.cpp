#include "host/analysis/twin/twin_shares.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "common/test/source.hpp"

namespace roadbalance {
namespace {

constexpr double kRate_hz = 500.0;

const TwinChannels& channels() {
  static const TwinChannels channels =
      TwinChannels::of(VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml")));
  return channels;
}

TwinSample sample_of(int k, double measured, double predicted) {
  const auto n = static_cast<Eigen::Index>(channels().channel.size());
  return {.time_ns = std::llround(k * 1e9 / kRate_hz),
          .speed_m_s = 30.0,
          .state = {},
          .measured = Eigen::VectorXd::Constant(n, measured),
          .predicted = Eigen::VectorXd::Constant(n, predicted)};
}

TEST(TwinShares, OfSinesAreWhatTheirAmplitudesSay) {
  TwinShares shares(channels(), kRate_hz, 0.0);
  // 15 Hz is in the band, 50 Hz is not; of the first 0.8 is predicted, of the second nothing.
  const TwinSecond* second = nullptr;
  for (int k = 0; k < 5000; ++k) {
    const double t = 2.0 * std::numbers::pi * k / kRate_hz;
    const double hop = 2.0 * std::sin(15.0 * t), high = 1.0 * std::sin(50.0 * t);
    if (const TwinSecond* newest = shares.add(sample_of(k, hop + high, 0.8 * hop))) second = newest;
  }
  ASSERT_NE(second, nullptr);
  const TwinAccount& account = second->channel[0].account;
  EXPECT_NEAR(account.all.measured, std::sqrt(2.5), 1e-6);
  EXPECT_NEAR(account.all.predicted, 0.8 * std::sqrt(2.0), 1e-6);
  EXPECT_NEAR(account.all.residual, std::sqrt(0.08 + 0.5), 1e-6);
  EXPECT_NEAR(account.all.share(), 1.0 - 0.58 / 2.5, 1e-6);
  // Gain of the band-pass, sqrt(1 + x^4)^-1 with x = (f^2 - f0^2) / (f B): 1.0000 at 15 Hz, 0.17 at 50 Hz.
  EXPECT_NEAR(account.hop.measured, std::sqrt(2.0 + 0.5 * 0.1653 * 0.1653 * 0.69), 0.02);
  EXPECT_GT(account.hop.share(), 0.94);
  EXPECT_EQ(shares.seconds()[0], 10);
}

TEST(TwinShares, CoherentShareIsWhatOneSourceGivesBoth) {
  TwinShares shares(channels(), kRate_hz, 0.0);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  // measured = source + own, predicted = 0.5 source: gamma^2 = 1 / (1 + 0.25).
  for (int k = 0; k < 200'000; ++k) {
    const double source = normal(random), own = 0.5 * normal(random);
    shares.add(sample_of(k, source + own, 0.5 * source));
  }
  const TwinAccount total = shares.total()[0];
  EXPECT_NEAR(total.coherent_all, 0.8, 0.01);
  EXPECT_NEAR(total.coherent_hop, 0.8, 0.03);
  EXPECT_NEAR(total.all.share(), 1.0 - (0.25 + 0.25) / 1.25, 0.01);
}

TEST(TwinShares, ASecondThatIsNotToldThroughoutDoesNotCount) {
  TwinShares shares(channels(), kRate_hz, 0.0);
  const TwinSecond* second = nullptr;
  for (int k = 0; k < 1500; ++k) {
    TwinSample sample = sample_of(k, std::sin(0.2 * k), 0.0);
    if (k == 700) sample.state[static_cast<std::size_t>(TwinPart::kRear)] = TwinState::kTooSlow;
    if (const TwinSecond* newest = shares.add(sample)) {
      second = newest;
      for (std::size_t c = 0; c < channels().channel.size(); ++c) {
        const bool cut = k == 999 && channels().channel[c].part == TwinPart::kRear;
        EXPECT_EQ(second->channel[c].account.state, cut ? TwinState::kTooSlow : TwinState::kPredicted);
      }
    }
  }
  for (std::size_t c = 0; c < channels().channel.size(); ++c)
    EXPECT_EQ(shares.seconds()[c], channels().channel[c].part == TwinPart::kRear ? 2 : 3);
}

TEST(TwinShares, AHoleEndsASecond) {
  TwinShares shares(channels(), kRate_hz, 0.0);
  int seconds = 0;
  for (int k = 0; k < 400; ++k) seconds += shares.add(sample_of(k, 1.0, 1.0)) != nullptr;
  for (int k = 1000; k < 1499; ++k) seconds += shares.add(sample_of(k, 1.0, 1.0)) != nullptr;
  EXPECT_EQ(seconds, 0);
  EXPECT_NE(shares.add(sample_of(1499, 1.0, 1.0)), nullptr);
}

TEST(TwinShares, TraceIsTheMeanOfNeighbours) {
  TwinShares shares(channels(), kRate_hz, 0.0);
  const TwinSecond* second = nullptr;
  for (int k = 0; k < 500; ++k)
    if (const TwinSecond* newest = shares.add(sample_of(k, k, -k))) second = newest;
  ASSERT_NE(second, nullptr);
  for (std::size_t p = 0; p < kTracePoints; ++p) {
    EXPECT_FLOAT_EQ(second->channel[0].measured[p], 4.0F * static_cast<float>(p) + 1.5F);
    EXPECT_FLOAT_EQ(second->channel[0].predicted[p], -4.0F * static_cast<float>(p) - 1.5F);
  }
}

}  // namespace
}  // namespace roadbalance
