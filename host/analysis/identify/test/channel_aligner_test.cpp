#include "host/analysis/identify/channel_aligner.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace roadbalance {
namespace {

constexpr double kRate_hz = 2000.0;

/// Channel c shows a sine of 17 + c Hz that lags by its delay; channel 15 counts scans.
std::int32_t shown(std::size_t c, std::int64_t scan, const ChannelDelays& delays) {
  if (c == 15) return static_cast<std::int32_t>(scan);
  const double t = static_cast<double>(scan) / kRate_hz - delays[c];
  return static_cast<std::int32_t>(
      std::lround(6e6 * std::sin(2.0 * std::numbers::pi * (17.0 + static_cast<double>(c)) * t)));
}

ScanBlock block_at(std::int64_t first, std::int64_t scans, const ChannelDelays& delays,
                   std::int64_t epoch = 1) {
  ScanBlock block;
  block.header = {1, epoch, 1 + first, first, scans, 1'000'000 + first * 500'000};
  block.period_ps = 500'000'000;
  for (std::int64_t r = 0; r < scans; ++r)
    for (std::size_t c = 0; c < kChannels; ++c)
      block.counts[static_cast<std::size_t>(r)][c] = shown(c, first + r, delays);
  return block;
}

TEST(ChannelAligner, PassesBlocksAsTheyAreWithoutDelays) {
  ChannelAligner aligner({});
  const ScanBlock block = block_at(40, 13, {});
  int came = 0;
  aligner.add(block, [&](const ScanBlock& out) {
    ++came;
    EXPECT_EQ(out.header, block.header);
    EXPECT_EQ(out.counts, block.counts);
  });
  EXPECT_EQ(came, 1);
}

TEST(ChannelAligner, BringsEveryChannelToTheInstantOfItsRow) {
  // Within a sample, across several, ahead; at most 10 ms.
  const ChannelDelays delays{0.0, 30e-6, -30e-6, 0.5e-3, 1.3e-3, -2.72e-3, 10e-3, -10e-3};
  ChannelAligner aligner(delays);
  std::int64_t next = -1, rows = 0;
  double worst = 0.0;
  for (std::int64_t first = 0; first < 2000; first += 20)
    aligner.add(block_at(first, 20, delays), [&](const ScanBlock& out) {
      EXPECT_TRUE(next < 0 || out.header.first_scan == next);
      next = out.header.first_scan + out.header.scans;
      for (std::int64_t r = 0; r < out.header.scans; ++r, ++rows) {
        const std::int64_t scan = out.header.first_scan + r;
        EXPECT_EQ(out.row_time_ns(r), 1'000'000 + scan * 500'000);
        for (std::size_t c = 0; c < kChannels; ++c) {
          const double off = out.counts[static_cast<std::size_t>(r)][c] - shown(c, scan, {});
          worst = std::max(worst, std::abs(off));
          EXPECT_TRUE(delays[c] != 0.0 || off == 0.0);
        }
      }
    });
  // 20 samples of delay either way and the interpolator's 15 and 16.
  EXPECT_EQ(rows, 2000 - 35 - 36);
  // 6e6 times the interpolator's error, 3e-5 at the most, and the rounding of both.
  EXPECT_LT(worst, 6e6 * 3e-5);
}

TEST(ChannelAligner, LeavesOutRowsThatAHoleOrAnotherEpochTouches) {
  const ChannelDelays delays{0.0, 30e-6};
  ChannelAligner aligner(delays);
  std::vector<std::pair<std::int64_t, std::int64_t>> runs;
  const auto take = [&](const ScanBlock& out) {
    if (runs.empty() || runs.back().second != out.header.first_scan)
      runs.push_back({out.header.first_scan, out.header.first_scan});
    runs.back().second += out.header.scans;
    for (std::int64_t r = 0; r < out.header.scans; ++r)
      EXPECT_NEAR(out.counts[static_cast<std::size_t>(r)][1], shown(1, out.header.first_scan + r, {}), 200);
  };
  for (std::int64_t first = 0; first < 400; first += 20)
    if (first != 200) aligner.add(block_at(first, 20, delays), take);
  aligner.add(block_at(400, 20, delays, 2), take);
  EXPECT_EQ(runs, (std::vector<std::pair<std::int64_t, std::int64_t>>{{15, 184}, {235, 384}}));
}

TEST(ChannelAligner, TellsOverloadAndQualityOfAllSamplesOfARow) {
  const ChannelDelays delays{0.0, 30e-6};
  ChannelAligner aligner(delays);
  std::vector<std::int64_t> flagged;
  for (std::int64_t first = 0; first < 200; first += 20) {
    ScanBlock block = block_at(first, 20, delays);
    if (first == 100) block.overload = 2, block.quality = kQualityOverload;
    aligner.add(block, [&](const ScanBlock& out) {
      if (out.overload == 2 && out.quality == kQualityOverload) flagged.push_back(out.header.first_scan);
    });
  }
  // Rows 84 to 134 are made of scans 100 to 119; blocks are cut after 23, 43, ...
  ASSERT_FALSE(flagged.empty());
  EXPECT_LE(flagged.front(), 84);
  EXPECT_GE(flagged.back() + 19, 134);
}

}  // namespace
}  // namespace roadbalance
