#include "host/analyser/spectrum_view.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "common/dsp/psd.hpp"
#include "host/analyser/test/noise_drive.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
using test::car, test::kFront, test::kRear, test::NoiseDrive;

const ChannelId kNoise{car().node[0].id, kFront.channel}, kHalf{car().node[1].id, kRear.channel};

View view(std::int64_t viewer = 1) {
  return {.viewer = viewer, .segment = 1024, .highest_hz = 1000.0, .spectrum = {kNoise, kHalf}};
}

class SpectrumViewTest : public testing::Test {
 protected:
  void drive(int blocks, std::int32_t overload = 0) {
    for (int i = 0; i < blocks; ++i)
      for (const int node : {0, 1}) {
        const SealedBlock sealed = drive_.next(node, node == 0 ? overload : 0);
        shown_.consume(sealed);
        if (node != 0) continue;
        const ScanBlock block = decode_scan(sealed);
        for (const auto& row : block.counts)
          sent_.push_back(car().node[0].channel[kFront.channel].to_si(row[kFront.channel]));
      }
  }
  /// [bin] of a channel, over its parts.
  static std::vector<double> whole(const std::vector<SpectrumPart>& parts, const ChannelId& channel) {
    std::vector<double> density;
    for (const SpectrumPart& part : parts)
      if (part.node == channel.node && part.channel == channel.channel)
        density.insert(density.end(), part.density.begin(), part.density.end());
    return density;
  }

  SpectrumView shown_{car()};
  NoiseDrive drive_;
  std::vector<double> sent_;
  const WallTime begin_ = WallClock::now();
};

TEST_F(SpectrumViewTest, TellsTheDensitiesThatWelchsMethodGivesOffline) {
  shown_.take(view(), begin_);
  drive(200);
  const auto parts = shown_.parts(begin_);
  WelchPsd offline({.rate_hz = 2000.0, .segment = 1024});
  offline.add(sent_);
  const auto expected = offline.density();
  const auto got = whole(parts, kNoise), half = whole(parts, kHalf);
  ASSERT_EQ(got.size(), expected.size());
  ASSERT_EQ(half.size(), expected.size());
  double sum = 0.0, sum_half = 0.0;
  for (std::size_t k = 0; k < got.size(); ++k) {
    // Both sum in double; the message rounds to 24 bits.
    EXPECT_NEAR(got[k] / expected[k], 1.0, 1e-7) << k;
    sum += got[k], sum_half += half[k];
  }
  EXPECT_NEAR(sum_half / sum, 0.25, 0.01);
  EXPECT_EQ(parts[0].viewer, 1);
  EXPECT_EQ(parts[0].averages, offline.averages());
  EXPECT_EQ(parts[0].parts, 2);
  EXPECT_NEAR(parts[0].enbw_hz, 1.5 * 2000.0 / 1024.0, 1e-9);
  EXPECT_NEAR(parts[1].first_hz, 300.0 * 2000.0 / 1024.0, 1e-9);
  EXPECT_TRUE(shown_.parts(begin_).empty()) << "nothing new";
}

TEST_F(SpectrumViewTest, NeighboursShownAsOneKeepTheMeanSquare) {
  View fine = view();
  fine.segment = 8192;  // 4097 bins
  shown_.take(fine, begin_);
  drive(1000);
  const auto parts = shown_.parts(begin_);
  const auto got = whole(parts, kNoise);
  ASSERT_FALSE(got.empty());
  EXPECT_LE(got.size(), SpectrumView::kMostShown);
  double mean_square = 0.0;
  for (const double density : got) mean_square += density * parts[0].step_hz;
  EXPECT_NEAR(mean_square, 1.0, 0.05);
}

TEST_F(SpectrumViewTest, AHeldPeakIsNeverBelowTheAverage) {
  View peaks = view(2);
  peaks.hold_peaks = true;
  shown_.take(view(), begin_);
  shown_.take(peaks, begin_);
  drive(400);
  std::map<std::int64_t, std::vector<SpectrumPart>> by_viewer;
  for (const SpectrumPart& part : shown_.parts(begin_)) by_viewer[part.viewer].push_back(part);
  const auto mean = whole(by_viewer[1], kNoise), held = whole(by_viewer[2], kNoise);
  ASSERT_EQ(mean.size(), held.size());
  EXPECT_TRUE(by_viewer[2][0].held);
  for (std::size_t k = 0; k < mean.size(); ++k) EXPECT_GE(held[k], mean[k]);
}

TEST_F(SpectrumViewTest, AChannelThatClipsCostsNoOther) {
  shown_.take(view(), begin_);
  drive(200, 1 << kFront.channel);
  const auto parts = shown_.parts(begin_);
  EXPECT_TRUE(whole(parts, kNoise).empty());
  EXPECT_FALSE(whole(parts, kHalf).empty());
}

TEST_F(SpectrumViewTest, SaysOnceThatThereIsNothingYetOrNoSuchChannel) {
  View strange = view();
  strange.spectrum = {kNoise, {99, 1}};
  shown_.take(strange, begin_);
  const auto parts = shown_.parts(begin_);
  ASSERT_EQ(parts.size(), 2U);
  for (const SpectrumPart& part : parts) {
    EXPECT_EQ(part.averages, 0);
    EXPECT_EQ(part.state, part.node == 99 ? SpectralState::kNoChannel : SpectralState::kTooShort);
    EXPECT_TRUE(part.density.empty());
  }
  EXPECT_TRUE(shown_.parts(begin_).empty());
}

TEST_F(SpectrumViewTest, IsForgottenInSilenceAndBounded) {
  shown_.take(view(), begin_);
  drive(200);
  EXPECT_TRUE(shown_.parts(begin_ + SpectrumView::kForgotten + 1ms).empty());
  for (std::int64_t viewer = 1; viewer < 100; ++viewer) {
    View other = view(viewer);
    other.memory = static_cast<std::int32_t>(viewer);
    shown_.take(other, begin_ + 10s);
  }
  drive(200);
  std::map<std::int64_t, bool> answered;
  for (const SpectrumPart& part : shown_.parts(begin_ + 10s))
    if (part.averages > 0) answered[part.viewer] = true;
  EXPECT_EQ(answered.size(), SpectrumView::kMostViewers);
}

TEST_F(SpectrumViewTest, SaysWhatIsMoreThanTheAnalyserHolds) {
  constexpr int kLong = 65'536, kViewers = 30;
  const std::size_t room =
      std::min(SpectrumView::kMostSpectra, SpectrumView::kMostBytesAll / CrossSpectra::bytes(1, kLong));
  ASSERT_LT(room, 2U * kViewers) << "the case that is tested";
  const auto ask = [&](std::int64_t viewer, WallTime now) {
    View wide = view(viewer);
    wide.segment = kLong;
    wide.memory = static_cast<std::int32_t>(viewer);
    shown_.take(wide, now);
  };
  for (std::int64_t viewer = 1; viewer <= kViewers; ++viewer) ask(viewer, begin_);
  std::map<SpectralState, std::size_t> answered;
  for (const SpectrumPart& part : shown_.parts(begin_)) {
    ++answered[part.state];
    EXPECT_TRUE(part.density.empty());
  }
  EXPECT_EQ(answered[SpectralState::kTooShort], room);
  EXPECT_EQ(answered[SpectralState::kTooMuch], 2U * kViewers - room);
  // The others have left.
  ask(kViewers, begin_ + SpectrumView::kForgotten + 1ms);
  const auto parts = shown_.parts(begin_ + SpectrumView::kForgotten + 1ms);
  ASSERT_EQ(parts.size(), 2U);
  for (const SpectrumPart& part : parts) EXPECT_EQ(part.state, SpectralState::kTooShort);
}

}  // namespace
}  // namespace roadbalance
