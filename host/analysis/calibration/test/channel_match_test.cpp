#include "host/analysis/calibration/channel_match.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace roadbalance {
namespace {

constexpr double kRate_hz = 100.0;
constexpr int kSegment = 50;  // a bin every 2 Hz

/// Two channels alike: impulses, as strong at every frequency, one to each half segment, more than enough of
/// them.
CrossSpectra two_alike() {
  CrossSpectra spectra({.welch = {.rate_hz = kRate_hz, .segment = kSegment}, .channels = 2});
  Eigen::MatrixXd samples = Eigen::MatrixXd::Zero(2, 40 * kSegment);
  for (Eigen::Index n = 12; n < samples.cols(); n += kSegment) samples.col(n).setConstant(1.0);
  spectra.add(samples);
  return spectra;
}

TEST(SpectraInBand, HoldBothEndsOfTheBand) {
  const BandSpectra band = spectra_in_band(two_alike(), 10.0, 14.0);
  EXPECT_EQ(band.frequency_hz, (std::vector<double>{10.0, 12.0, 14.0}));
  ASSERT_EQ(band.matrix.size(), 3U);
  EXPECT_EQ(band.matrix[0].rows(), 2);
  EXPECT_EQ(match_channels(band, {0, 1}).refusal, ChannelMatches::Reason::kNone);
}

TEST(SpectraInBand, MayBeNoneAndThenNothingIsMatched) {
  for (const auto& [low_hz, high_hz] :
       {std::pair{10.5, 11.5}, {kRate_hz / 2.0 + 1.0, kRate_hz}, {14.0, 10.0}}) {
    const BandSpectra band = spectra_in_band(two_alike(), low_hz, high_hz);
    EXPECT_TRUE(band.frequency_hz.empty() && band.matrix.empty()) << low_hz;
    ASSERT_GE(band.averages, kLeastAverages);
    const ChannelMatches matches = match_channels(band, {0, 1});
    EXPECT_EQ(matches.refusal, ChannelMatches::Reason::kNoTwoAlike) << low_hz;
    EXPECT_TRUE(matches.channel.empty());
  }
}

}  // namespace
}  // namespace roadbalance
