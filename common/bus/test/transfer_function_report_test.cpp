#include "common/bus/transfer_function_report.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace roadbalance {
namespace {

View view() {
  return {.viewer = 77,
          .segment = 8192,
          .window = Window::kFlatTop,
          .memory = 12,
          .hold_peaks = true,
          .overlap = 0.75,
          .highest_hz = 400.0,
          .pair = {{{1, 2}, {2, 11}}, {{2, 0}, {1, 3}}},
          .spectrum = {{1, 2}, {3, 4}},
          .envelope = {{5, 6}},
          .waterfall = {{3, {2, 9}}}};
}

TEST(TransferFunctionReport, AViewComesBackAsItWasSent) {
  const auto bytes = encode(view());
  EXPECT_LT(bytes.size(), 1400U) << "one datagram";
  const auto got = decode_view(bytes);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->viewer, 77);
  EXPECT_EQ(got->segment, 8192);
  EXPECT_EQ(got->window, Window::kFlatTop);
  EXPECT_EQ(got->memory, 12);
  EXPECT_EQ(got->overlap, 0.75);
  EXPECT_EQ(got->highest_hz, 400.0);
  ASSERT_EQ(got->pair.size(), 2U);
  EXPECT_EQ(got->pair[0].output, (ChannelId{2, 11}));
  EXPECT_EQ(got->pair[1].input, (ChannelId{2, 0}));
  EXPECT_TRUE(got->hold_peaks);
  EXPECT_EQ(got->spectrum, view().spectrum);
  EXPECT_EQ(got->envelope, view().envelope);
  EXPECT_EQ(got->waterfall, view().waterfall);
}

TEST(TransferFunctionReport, AViewThatCannotBeIsRefused) {
  const auto refused = [](auto&& spoil) {
    View sent = view();
    spoil(sent);
    return !decode_view(encode(sent));
  };
  EXPECT_FALSE(refused([](View&) {}));
  EXPECT_TRUE(refused([](View& v) { v.segment = kLongestSegment + 1; }));
  EXPECT_TRUE(refused([](View& v) { v.segment = kShortestSegment - 1; }));
  EXPECT_TRUE(refused([](View& v) { v.overlap = 0.8; }));
  EXPECT_TRUE(refused([](View& v) { v.overlap = std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_TRUE(refused([](View& v) { v.highest_hz = std::numeric_limits<double>::infinity(); }));
  EXPECT_TRUE(refused([](View& v) { v.window = static_cast<Window>(3); }));
  EXPECT_TRUE(refused([](View& v) { v.memory = -1; }));
  EXPECT_TRUE(refused([](View& v) { v.pair[1].output.channel = 16; }));
  EXPECT_TRUE(refused([](View& v) { v.spectrum[1].channel = -1; }));
  EXPECT_TRUE(refused([](View& v) { v.envelope[0].channel = 16; }));
  EXPECT_TRUE(refused([](View& v) { v.waterfall[0].wheel = 4; }));
  auto bytes = encode(view());
  bytes.push_back(0);
  EXPECT_FALSE(decode_view(bytes));
}

TEST(TransferFunctionReport, APartComesBackAsItWasSent) {
  TransferFunctionPart sent{.viewer = 5,
                            .pair = {{1, 2}, {2, 4}},
                            .time_ns = 123,
                            .part = 2,
                            .parts = 3,
                            .first_hz = 48.0,
                            .step_hz = 0.5,
                            .enbw_hz = 0.75,
                            .independent_averages = 17.5,
                            .coherence_by_chance = 0.17,
                            .bin = std::vector<TransferFunctionPart::Bin>(
                                kTransferFunctionBinsPerPart, {1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 0.5F})};
  const auto bytes = encode(sent);
  EXPECT_LT(bytes.size(), 1400U) << "one datagram";
  const auto got = decode_transfer_function(bytes);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->pair.output, (ChannelId{2, 4}));
  EXPECT_EQ(got->part, 2);
  EXPECT_EQ(got->first_hz, 48.0);
  EXPECT_EQ(got->coherence_by_chance, 0.17);
  ASSERT_EQ(got->bin.size(), kTransferFunctionBinsPerPart);
  EXPECT_EQ(got->bin[47].h1_im, 4.0F);
  EXPECT_EQ(got->bin[47].coherence, 0.5F);
  sent.state = static_cast<SpectralState>(5);
  EXPECT_FALSE(decode_transfer_function(encode(sent))) << "there is no such state";
  sent.state = SpectralState::kNoCommonTime;
  EXPECT_EQ(decode_transfer_function(encode(sent))->state, SpectralState::kNoCommonTime);
  sent.part = 3;
  EXPECT_FALSE(decode_transfer_function(encode(sent))) << "there is no such part";
}

}  // namespace
}  // namespace roadbalance
