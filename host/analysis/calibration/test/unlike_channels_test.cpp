// Channels of which some do not show what the others do.
#include <gtest/gtest.h>

#include <cmath>

#include "host/analysis/calibration/test/inputs.hpp"

namespace roadbalance {
namespace {

using test::compare;
using test::hiss;
using test::Inputs;
using test::kRate_hz;
using test::kTwoPi;
using test::node_of;

TEST(UnlikeChannels, LeavesAnInputAloneThatOnlyHearsItsNeighbours) {
  Inputs inputs;
  inputs.gain[3] = 0.01;  // floats beside eleven that are driven
  inputs.gain[6] = 1.19;
  const auto result = compare(node_of(), inputs, 20.0);
  ASSERT_EQ(result.channel.size(), 12U);
  for (std::size_t c = 0; c < 12; ++c) {
    EXPECT_EQ(result.channel[c].match.verdict,
              c == 3 ? ChannelMatch::Verdict::kOtherSize : ChannelMatch::Verdict::kMatched)
        << c;
    EXPECT_EQ(result.channel[c].can_be_set, c != 3) << c;
  }
  EXPECT_NEAR(result.channel[3].match.gain, 0.01, 1e-4) << "it is said what was seen";
  const auto by_it = compare(node_of(), inputs, 20.0, {.reference = node_of().channel[3].name});
  EXPECT_TRUE(by_it.channel.empty()) << "else all others would be made a hundred times larger";
  EXPECT_NE(by_it.refusal.find(node_of().channel[3].name + " does not show"), std::string::npos)
      << by_it.refusal;
  // A loop-back without a signal hears its neighbours, too, 90 us late.
  for (std::size_t c = 12; c < 16; ++c) inputs.gain[c] = 0.01, inputs.cutoff_factor[c] = 0.97;
  const NodeConfig node = node_of([](NodeConfig& n) { n.wiring.loop_back = true; });
  EXPECT_NEAR(compare(node, inputs, 20.0).channel[0].delay_s, 0.0, 1e-8);
}

TEST(UnlikeChannels, SaysWhichObstacleThereIs) {
  Inputs inputs;
  inputs.gain[1] = 0.0;
  const NodeConfig node = node_of();
  const auto of_silent = compare(node, inputs, 20.0, {.reference = node.channel[1].name});
  EXPECT_NE(of_silent.refusal.find(node.channel[1].name + " does not show the signal"), std::string::npos)
      << of_silent.refusal;
  EXPECT_NE(compare(node, inputs, 5.0).refusal.find("11 s at least"), std::string::npos);
  inputs.gain.fill(0.0);
  EXPECT_EQ(compare(node, inputs, 20.0).refusal, "no two channels show the same signal");
}

TEST(UnlikeChannels, ComparesOneMotionWithoutTheLoopBack) {
  Inputs inputs;
  // Sine and cosine of a wheel, in counts, beside accelerations in m/s^2: in its own band it is the
  // strongest.
  for (std::size_t c = 12; c < 16; ++c) inputs.gain[c] = 0.0;
  const NodeConfig node = node_of([](NodeConfig& n) {
    n.wiring.loop_back = true;
    for (auto& channel : n.channel) channel.scale_m_s2_per_count = 1e-5;
  });
  ChannelComparison comparison(node, {.motion = true});
  inputs.run(20.0, hiss(0.2), [&](ScanBlock block) {
    for (std::int64_t r = 0; r < block.header.scans; ++r) {
      const double angle = kTwoPi * 15.0 * static_cast<double>(block.header.first_scan + r) / kRate_hz;
      auto& counts = block.counts[static_cast<std::size_t>(r)];
      for (std::size_t c = 12; c < 16; ++c)
        counts[c] =
            static_cast<std::int32_t>(kFullScaleCounts * (c % 2 == 0 ? std::sin(angle) : std::cos(angle)));
    }
    comparison.add(block);
  });
  const auto result = comparison.result();
  ASSERT_EQ(result.channel.size(), 12U) << result.refusal;
  for (const auto& channel : result.channel)
    EXPECT_EQ(channel.match.verdict, ChannelMatch::Verdict::kMatched) << channel.name;
  EXPECT_THROW(ChannelComparison(node, {.motion = true, .reference = "reference_13"}), ConfigError);
}

TEST(UnlikeChannels, IsInterruptedByAnOverloadOfWhatItComparesOnly) {
  const NodeConfig node = node_of([](NodeConfig& n) { n.channel[5].role = ChannelRole::kUnused; });
  for (const int overloaded : {5, 4}) {
    ChannelComparison comparison(node, {});
    Inputs{}.run(20.0, hiss(0.2), [&](ScanBlock block) {
      block.overload = 1 << overloaded;
      comparison.add(block);
    });
    const auto result = comparison.result();
    if (overloaded == 5) {
      EXPECT_EQ(result.channel.size(), 11U) << "nothing is connected there";
      EXPECT_EQ(result.overload_s, 0.0);
    } else {
      EXPECT_TRUE(result.channel.empty());
      EXPECT_NEAR(result.overload_s, 19.0, 0.02) << "20 s without the first";
    }
  }
}

}  // namespace
}  // namespace roadbalance
