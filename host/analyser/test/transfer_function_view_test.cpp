#include "host/analyser/transfer_function_view.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <map>
#include <set>

#include "common/dsp/transfer_function.hpp"
#include "host/analyser/test/noise_drive.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
using test::car, test::kFront, test::kRear, test::NoiseDrive;

const ChannelId kInput{car().node[0].id, kFront.channel}, kOutput{car().node[1].id, kRear.channel};

View view(std::int64_t viewer = 1) {
  return {.viewer = viewer, .segment = 1024, .highest_hz = 1000.0, .pair = {{kInput, kOutput}}};
}

class TransferFunctionViewTest : public testing::Test {
 protected:
  void drive(int blocks) {
    for (int i = 0; i < blocks; ++i)
      for (const int node : {0, 1}) shown_.consume(drive_.next(node));
  }
  TransferFunctionView shown_{car()};
  NoiseDrive drive_;
  const WallTime begin_ = WallClock::now();
};

TEST_F(TransferFunctionViewTest, TellsNothingThatNobodyAskedFor) {
  drive(200);
  EXPECT_TRUE(shown_.parts(begin_).empty());
}

TEST_F(TransferFunctionViewTest, APairOfTwoNodesComesInPartsThatFitTogether) {
  shown_.take(view(), begin_);
  drive(200);
  const auto parts = shown_.parts(begin_ + 1s);
  ASSERT_FALSE(parts.empty());
  // 513 bins are fewer than may be shown: each is.
  EXPECT_EQ(parts.size(), (513 + kTransferFunctionBinsPerPart - 1) / kTransferFunctionBinsPerPart);
  std::size_t bins = 0;
  for (const TransferFunctionPart& part : parts) {
    EXPECT_EQ(part.viewer, 1);
    EXPECT_EQ(part.pair.output, kOutput);
    EXPECT_EQ(part.parts, static_cast<std::int32_t>(parts.size()));
    EXPECT_NEAR(part.first_hz, static_cast<double>(bins) * 2000.0 / 1024.0, 1e-9);
    for (const TransferFunctionPart::Bin& bin : part.bin) {
      const double hz = static_cast<double>(bins++) * part.step_hz;
      if (hz < 10.0 || hz > 990.0) continue;
      // Half as much, three samples later.
      const auto expected = std::polar(0.5, -2.0 * std::acos(-1.0) * hz * 3.0 / 2000.0);
      EXPECT_LT(std::abs(std::complex<double>(bin.h1_re, bin.h1_im) - expected), 0.02) << hz;
      EXPECT_GT(bin.coherence, 0.99F);
      EXPECT_NEAR(bin.output / bin.input, 0.25F, 0.02F);
    }
  }
  EXPECT_EQ(bins, 513U);
  EXPECT_TRUE(shown_.parts(begin_ + 1s).empty()) << "nothing new";
  drive(60);
  EXPECT_FALSE(shown_.parts(begin_ + 1s).empty());
}

TEST_F(TransferFunctionViewTest, TellsTheNumbersThatTheSameScansGiveOffline) {
  shown_.take(view(), begin_);
  JointSpectra offline(car(), {kFront, kRear}, {.segment = 1024});
  for (int i = 0; i < 200; ++i)
    for (const int node : {0, 1}) {
      const SealedBlock block = drive_.next(node);
      shown_.consume(block);
      offline.consume(block);
    }
  const CrossSpectra& spectra = offline.spectra();
  const TransferFunction h = transfer_function(spectra.density(0), spectra.density(1), spectra.density(0, 1),
                                               spectra.independent_averages());
  std::size_t k = 0;
  // The message rounds to 24 bits.
  const auto near = [](float shown, double expected) {
    return std::abs(shown - expected) <= 6e-8 * std::abs(expected);
  };
  for (const TransferFunctionPart& part : shown_.parts(begin_))
    for (const TransferFunctionPart::Bin& bin : part.bin) {
      EXPECT_TRUE(near(bin.input, spectra.density(0)[k])) << k;
      EXPECT_TRUE(near(bin.output, spectra.density(1)[k])) << k;
      EXPECT_TRUE(near(bin.h1_re, h.h1[k].real()) && near(bin.h1_im, h.h1[k].imag())) << k;
      EXPECT_TRUE(near(bin.coherence, h.coherence[k])) << k;
      EXPECT_TRUE(near(bin.radius_95, h.radius_95[k])) << k;
      ++k;
    }
  EXPECT_EQ(k, h.h1.size());
}

TEST_F(TransferFunctionViewTest, ManyBinsAreShownAsFewerThatScatterLess) {
  View fine = view();
  fine.segment = 8192;  // 4097 bins, eight of which are shown as one
  shown_.take(fine, begin_);
  drive(1000);
  const auto parts = shown_.parts(begin_);
  ASSERT_FALSE(parts.empty());
  EXPECT_NEAR(parts[0].step_hz, 8.0 * 2000.0 / 8192.0, 1e-9);
  EXPECT_NEAR(parts[0].first_hz, 3.5 * 2000.0 / 8192.0, 1e-9);
  EXPECT_EQ(parts.size(), (512 + kTransferFunctionBinsPerPart - 1) / kTransferFunctionBinsPerPart);
  // 20 000 samples, half over half: three segments, worth 2.8; eight bins of Hann are worth 8 / 1.5.
  EXPECT_NEAR(parts[0].independent_averages, 2.82 * 8.0 / 1.5, 0.6);
  EXPECT_NEAR(parts[5].bin[7].output / parts[5].bin[7].input, 0.25F, 0.02F);
}

TEST_F(TransferFunctionViewTest, AViewerWhoFallsSilentIsForgottenAndWhatHeLookedAtBeginsAnew) {
  shown_.take(view(), begin_);
  drive(200);
  EXPECT_TRUE(shown_.parts(begin_ + TransferFunctionView::kForgotten + 1ms).empty());
  shown_.take(view(), begin_ + 10s);
  const auto first = shown_.parts(begin_ + 10s);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].state, SpectralState::kTooShort) << "what was averaged is gone";
  EXPECT_TRUE(shown_.parts(begin_ + 10s).empty()) << "said once";
  drive(60);
  EXPECT_FALSE(shown_.parts(begin_ + 10s).empty());
}

TEST_F(TransferFunctionViewTest, WhatIsAskedForAnewIsToldAtOnceFromTheSameAverage) {
  shown_.take(view(), begin_);
  drive(200);
  const auto first = shown_.parts(begin_);
  View other = view();
  other.pair = {{kOutput, kInput}};
  shown_.take(other, begin_);
  const auto second = shown_.parts(begin_);
  ASSERT_EQ(second.size(), first.size());
  EXPECT_EQ(second[0].pair.input, kOutput);
  EXPECT_EQ(second[0].independent_averages, first[0].independent_averages);
  EXPECT_EQ(second[3].bin[5].input, first[3].bin[5].output);
  shown_.take(other, begin_);
  EXPECT_TRUE(shown_.parts(begin_).empty()) << "the same again is no news";
}

TEST_F(TransferFunctionViewTest, LimitsWhatViewersCanCostAndSaysSo) {
  for (std::size_t k = 0; k < TransferFunctionView::kMostSpectra + 2; ++k) {
    View one = view(static_cast<std::int64_t>(k));
    one.segment = 1024 + static_cast<std::int32_t>(k);
    one.pair.push_back({{99, 0}, kInput});  // no such node
    shown_.take(one, begin_);
  }
  View dear = view(100);
  dear.segment = kLongestSegment;
  dear.pair.clear();
  for (std::int32_t c = 0; c < 12; ++c) dear.pair.push_back({{kInput.node, c}, {kOutput.node, c}});
  shown_.take(dear, begin_);
  drive(200);
  std::map<SpectralState, std::set<std::int64_t>> viewers;
  for (const TransferFunctionPart& part : shown_.parts(begin_)) {
    viewers[part.state].insert(part.viewer);
    if (part.pair.input.node == 99) {
      EXPECT_EQ(part.state, SpectralState::kNoChannel);
    }
    EXPECT_EQ(part.bin.empty(), part.state != SpectralState::kComputed);
  }
  EXPECT_EQ(viewers[SpectralState::kComputed].size(), TransferFunctionView::kMostSpectra);
  EXPECT_EQ(viewers[SpectralState::kTooMuch], (std::set<std::int64_t>{8, 9, 100}));
  // Two who were refused stay, the others leave.
  for (const std::int64_t id : {8, 9}) {
    View again = view(id);
    again.segment = 1024 + static_cast<std::int32_t>(id);
    again.pair.push_back({{99, 0}, kInput});
    shown_.take(again, begin_ + 2s);
    shown_.take(again, begin_ + 4s);
  }
  drive(60);
  viewers.clear();
  for (const TransferFunctionPart& part : shown_.parts(begin_ + 4s)) viewers[part.state].insert(part.viewer);
  EXPECT_EQ(viewers[SpectralState::kComputed], (std::set<std::int64_t>{8, 9}));
}

TEST_F(TransferFunctionViewTest, ASilentNodeOrAClippingChannelKeepsNobodyFromSeeingOthers) {
  View front = view();
  front.pair = {{kInput, {kInput.node, kInput.channel + 1}}};
  shown_.take(front, begin_);
  shown_.take(view(2), begin_);
  for (int i = 0; i < 200; ++i)
    shown_.consume(drive_.next(0, i % 5 == 0 ? 1 << 9 : 0));  // the rear is silent
  bool shown = false;
  for (const TransferFunctionPart& part : shown_.parts(begin_)) {
    EXPECT_EQ(part.state, part.viewer == 1 ? SpectralState::kComputed : SpectralState::kTooShort);
    shown = shown || part.viewer == 1;
  }
  EXPECT_TRUE(shown);
}

TEST_F(TransferFunctionViewTest, NodesOfWhoseClocksItHeardBeforeAreJoinedByThem) {
  // The rear node's clock is 1 ms (two samples) ahead of the host's: of the three samples that its signal
  // lags by its own clock, it truly lags five.
  for (const int node : {0, 1})
    shown_.consume(ClockFit{.node = car().node[static_cast<std::size_t>(node)].id,
                            .epoch = 1,
                            .number = 1,
                            .state = ClockState::kLocked,
                            .host_ns = 0,
                            .node_ns = node == 1 ? -1'000'000 : 0,
                            .uncertainty_s = 1e-6});
  shown_.take(view(), begin_);
  drive(200);
  const auto parts = shown_.parts(begin_);
  ASSERT_FALSE(parts.empty());
  ASSERT_EQ(parts[0].state, SpectralState::kComputed);
  const TransferFunctionPart::Bin& bin = parts[0].bin[40];
  const double hz = 40.0 * parts[0].step_hz;
  EXPECT_NEAR(std::arg(std::complex<double>(bin.h1_re, bin.h1_im)),
              -2.0 * std::acos(-1.0) * hz * 5.0 / 2000.0, 0.02);
}

}  // namespace
}  // namespace roadbalance
