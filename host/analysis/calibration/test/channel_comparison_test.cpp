#include "host/analysis/calibration/channel_comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "host/analysis/calibration/test/inputs.hpp"
#include "host/analysis/identify/channel_aligner.hpp"

namespace roadbalance {
namespace {

using test::compare;
using test::hiss;
using test::Inputs;
using test::kRate_hz;
using test::kTwoPi;
using test::node_of;

/// Degrees by which channel `a` lags behind `b` at a frequency, as blocks show it.
class PhaseMeter {
 public:
  PhaseMeter(std::size_t a, std::size_t b, double frequency_hz) : a_(a), b_(b), frequency_hz_(frequency_hz) {}
  void add(const ScanBlock& block) {
    for (std::int64_t r = 0; r < block.header.scans; ++r) {
      const auto& counts = block.counts[static_cast<std::size_t>(r)];
      const double t = static_cast<double>(block.header.first_scan + r) / kRate_hz;
      if (t < 2.0 || t >= 4.0) continue;  // whole turns of every frequency asked for
      const auto turn = std::polar(1.0, -kTwoPi * frequency_hz_ * t);
      sum_a_ += turn * static_cast<double>(counts[a_]);
      sum_b_ += turn * static_cast<double>(counts[b_]);
    }
  }
  double lag_deg() const { return std::arg(sum_b_ / sum_a_) * 360.0 / kTwoPi; }

 private:
  std::size_t a_, b_;
  double frequency_hz_;
  std::complex<double> sum_a_, sum_b_;
};

TEST(ChannelComparison, TakesAFiltersMismatchOutOfTheAngles) {
  Inputs inputs;
  inputs.noise = 1e-4;
  inputs.cutoff_factor[2] = 0.99;
  for (const auto& [order, cutoff_hz] : {std::pair{4, 100.0}, {6, 200.0}, {8, 400.0}}) {
    inputs.filter = {order, cutoff_hz};
    NodeConfig node = node_of();
    const auto result = compare(node, inputs, 60.0);
    ASSERT_EQ(result.channel.size(), 12U);
    for (std::size_t c = 0; c < 12; ++c) {
      ASSERT_EQ(result.channel[c].match.verdict, ChannelMatch::Verdict::kMatched) << c;
      node.channel[c].delay_s = result.channel[c].delay_s;
    }
    // The delay of the filter at rest is the sum of 2 sin((2 k - 1) pi / 2 n), k to n / 2, over its corner.
    double at_rest = 0.0;
    for (int k = 1; k <= order / 2; ++k)
      at_rest += 2.0 * std::sin((2 * k - 1) * std::numbers::pi / (2 * order));
    const double lag_s = at_rest / (kTwoPi * cutoff_hz) * (1.0 / 0.99 - 1.0);
    EXPECT_NEAR(result.channel[2].delay_s, lag_s, 0.05 * lag_s);  // less straight at 100 Hz
    for (const double frequency_hz : {5.0, 10.0, 15.0, 18.0, 20.0, 25.0}) {
      PhaseMeter before(2, 0, frequency_hz), after(2, 0, frequency_hz);
      ChannelAligner aligner(delays_of(node));
      inputs.run(
          4.1, [&](double t) { return 0.5 * std::sin(kTwoPi * frequency_hz * t); },
          [&](const ScanBlock& block) {
            before.add(block);
            aligner.add(block, [&](const ScanBlock& aligned) { after.add(aligned); });
          });
      std::printf("order %d, %.0f Hz, 1 %% apart: at %4.0f Hz %.4f deg before, %.5f after\n", order,
                  cutoff_hz, frequency_hz, before.lag_deg(), after.lag_deg());
      EXPECT_NEAR(before.lag_deg(), 360.0 * frequency_hz * lag_s, 0.1 * 360.0 * frequency_hz * lag_s);
      EXPECT_LT(std::abs(after.lag_deg()), 0.01);
    }
  }
}

TEST(ChannelComparison, StatesItsUncertainty) {
  Inputs inputs;
  inputs.noise = 0.004;
  double delays = 0.0, gains = 0.0;
  constexpr int kRuns = 6;
  for (int run = 0; run < kRuns; ++run) {
    inputs.seed = 100U + static_cast<unsigned>(run);
    const auto result = compare(node_of(), inputs, 30.0);
    for (const auto& channel : result.channel) {
      delays += std::pow(channel.match.delay_s / channel.match.delay_sigma_s, 2);
      gains += std::pow((channel.match.gain - 1.0) / channel.match.gain_sigma, 2);
    }
  }
  // Chi squared of 66, over 72 channels: its mean and three of its sigmas.
  for (const double square : {delays / (12 * kRuns), gains / (12 * kRuns)}) {
    std::printf("squared error over its variance: %.2f\n", square);
    EXPECT_NEAR(square, 1.0, 0.52);
  }
}

TEST(ChannelComparison, FindsGainsWithoutTheSensors) {
  Inputs inputs;
  inputs.gain[4] = 1.02;
  inputs.gain[7] = 0.95;
  const NodeConfig node = node_of([](NodeConfig& n) { n.channel[7].offset_counts = 12.0; });
  const auto result = compare(node, inputs, 20.0);
  for (std::size_t c = 0; c < 12; ++c) {
    const auto& channel = result.channel[c];
    EXPECT_NEAR(channel.match.gain, inputs.gain[c], 1e-5);
    // Units per count, times the counts of the same voltage, are the range of its sensor.
    EXPECT_NEAR(channel.scale_m_s2_per_count * inputs.gain[c], node.channel[c].range_m_s2 / kFullScaleCounts,
                1e-5 * channel.scale_m_s2_per_count);
    EXPECT_EQ(channel.offset_counts, node.channel[c].offset_counts);
  }
  // For one motion their calibration counts, and the reference stays as it is.
  const NodeConfig shaken = node_of([](NodeConfig& n) {
    for (auto& channel : n.channel) channel.scale_m_s2_per_count = 1e-5;
    n.channel[4].delay_s = 3e-6;
  });
  const auto moved = compare(shaken, inputs, 20.0, {.motion = true, .reference = "fl_strut_y"});
  EXPECT_NEAR(moved.channel[4].scale_m_s2_per_count, 1e-5, 1e-12);
  EXPECT_NEAR(moved.channel[4].delay_s, 3e-6, 1e-12);
  EXPECT_NEAR(moved.channel[7].scale_m_s2_per_count, 1e-5 * 1.02 / 0.95, 1e-10);
  EXPECT_NEAR(moved.channel[0].delay_s, 3e-6, 1e-8);
}

TEST(ChannelComparison, RefusesChannelsThatShowAnotherSignalOrNone) {
  Inputs inputs;
  inputs.noise = 1e-4;
  inputs.gain[1] = 0.0;
  inputs.gain[5] = -1.0;
  inputs.cutoff_factor[9] = 0.2;  // that is no delay any more
  const auto result = compare(node_of(), inputs, 20.0, {.high_hz = 60.0});
  using Verdict = ChannelMatch::Verdict;
  for (std::size_t c = 0; c < 12; ++c) {
    const Verdict expected = c == 1   ? Verdict::kNoCoherence
                             : c == 5 ? Verdict::kInverted
                             : c == 9 ? Verdict::kNoDelay
                                      : Verdict::kMatched;
    EXPECT_EQ(result.channel[c].match.verdict, expected) << c;
    EXPECT_EQ(result.channel[c].can_be_set, expected == Verdict::kMatched) << c;
    if (expected != Verdict::kMatched) continue;
    EXPECT_NEAR(result.channel[c].match.gain, 1.0, 1e-3) << c;
  }
  inputs.gain.fill(0.0);
  EXPECT_TRUE(compare(node_of(), inputs, 20.0).channel.empty());
}

TEST(ChannelComparison, TakesTheLoopBackForTheReferenceOfDelays) {
  Inputs inputs;
  inputs.filter = {6, 200.0};
  for (std::size_t c = 0; c < 12; ++c) inputs.cutoff_factor[c] = 0.99;
  const NodeConfig node = node_of([](NodeConfig& n) { n.wiring.loop_back = true; });
  const auto result = compare(node, inputs, 20.0);
  ASSERT_EQ(result.channel.size(), 16U);
  // 3.8637 / (2 pi 200 Hz) at rest, a hundredth more.
  for (std::size_t c = 0; c < 12; ++c) EXPECT_NEAR(result.channel[c].delay_s, 31.06e-6, 0.4e-6);
  for (std::size_t c = 12; c < 16; ++c) EXPECT_FALSE(result.channel[c].can_be_set);
  // They had no signal: the median of the rest is what is left.
  for (std::size_t c = 12; c < 16; ++c) inputs.gain[c] = 0.0;
  for (const auto& channel : compare(node, inputs, 20.0).channel) EXPECT_NEAR(channel.delay_s, 0.0, 1e-9);
}

TEST(ChannelComparison, SaysWhatCannotBeCompared) {
  EXPECT_THROW(ChannelComparison(node_of(), {.reference = "no_such"}), ConfigError);
  EXPECT_THROW(ChannelComparison(node_of(), {.low_hz = 30.0, .high_hz = 20.0}), ConfigError);
  EXPECT_THROW(ChannelComparison(node_of([](NodeConfig& n) { n.channel[3].input_range_v = 5.0; }), {}),
               ConfigError);
}

}  // namespace
}  // namespace roadbalance
