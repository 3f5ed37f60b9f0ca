#include "host/analysis/identify/grid_stream.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/analysis/identify/test/gridded_node.hpp"

namespace roadbalance {
namespace {

using test::kAmplitude, test::Node, test::rows_in, test::worst_error;

TEST(GridStream, ANodeOnTheGridIsTheGridBitForBit) {
  const Node node;
  Grid grid;
  GridStream stream(1, false);
  for (int number = 0; number < 50; ++number) stream.take(node.block(number), grid);
  ASSERT_EQ(stream.rows.size(), 50U);
  for (int number = 0; number < 50; ++number) {
    const ScanBlock block = node.block(number);
    const GridRows& rows = stream.rows.at_hand()[static_cast<std::size_t>(number)];
    EXPECT_EQ(rows.first_index, block.header.first_scan);
    EXPECT_EQ(rows.time_ns, block.header.time_ns);
    for (std::size_t r = 0; r < kScansPerBlock; ++r)
      for (std::size_t c = 0; c < kChannels; ++c)
        ASSERT_EQ(static_cast<double>(rows.counts[r][c]), static_cast<double>(block.counts[r][c]));
  }
}

TEST(GridStream, AnyClockAndConverterGiveTheTruthAtTheGridsInstants) {
  for (const double rate_hz : {500.0, 2000.0})
    for (const double ppm : {-300.0, 0.0, 50.0}) {
      const Node node{.rate_hz = rate_hz, .offset_s = -1000.25, .drift = 40e-6, .ppm = ppm, .begin_s = 77.0};
      Grid grid{.origin_ns = 70'000'000'000, .period_ps = std::llround(1e12 / rate_hz)};
      GridStream stream(1, false);
      stream.take(node.fit(80.0), grid);
      constexpr int kBlocks = 400;
      for (int number = 0; number < kBlocks; ++number) stream.take(node.block(number), grid);
      const double scans = kBlocks * kScansPerBlock / (1.0 + 1e-6 * ppm);
      EXPECT_NEAR(static_cast<double>(rows_in(stream)), scans - FractionalDelay::kTaps, 2.0);
      // The converter's rate is known from the second block on.
      while (stream.rows.front().first_index < stream.rows.back().first_index &&
             static_cast<double>(grid.time_ns(stream.rows.front().first_index)) < 1e9 * node.host_s(36))
        stream.rows.pop_front();
      // Four tones, each right to 0.002 degrees with half a count of rounding: all together less than the
      // 0.01 degrees that the one at 25 Hz may be wrong by.
      EXPECT_LT(worst_error(stream, grid), 4.0 * kAmplitude * 0.002 * std::numbers::pi / 180.0)
          << rate_hz << " Hz, " << ppm << " ppm";
      for (std::size_t i = 1; i < stream.rows.size(); ++i)
        ASSERT_EQ(stream.rows.at_hand()[i].first_index,
                  stream.rows.at_hand()[i - 1].first_index + stream.rows.at_hand()[i - 1].rows);
    }
}

TEST(GridStream, ASharedClockWithAFreeConverterIsResampledToo) {
  const Node node{.ppm = 50.0};
  Grid grid{.origin_ns = 0, .period_ps = 500'000'000};
  GridStream stream(1, false);
  for (int number = 0; number < 1000; ++number) stream.take(node.block(number), grid);
  // Before its samples are 0.02 periods off the grid they are taken for the grid's: 10 us at 60 Hz are 0.4 %.
  EXPECT_LT(worst_error(stream, grid),
            kAmplitude * 1.1 * 2.0 * std::numbers::pi * 10e-6 * (1 + 18 + 25 + 60));
  while (!stream.rows.empty() && stream.rows.front().first_index < 2000) stream.rows.pop_front();
  EXPECT_LT(worst_error(stream, grid), 4.0 * kAmplitude * 0.002 * std::numbers::pi / 180.0);
  EXPECT_GT(rows_in(stream), 17'900);
}

TEST(GridStream, ItsOnlyNodeNeedsNoOtherClock) {
  const Node node{.offset_s = 500.0};
  Grid grid;
  GridStream stream(1, true);
  stream.take(node.acquiring(0.0), grid);
  for (int number = 0; number < 10; ++number) stream.take(node.block(number), grid);
  EXPECT_EQ(rows_in(stream), 10 * kScansPerBlock);
}

TEST(GridStream, AGapCostsWhatTheFilterNeedsAndRestarts) {
  const Node node{.offset_s = 3.0, .ppm = 20.0, .begin_s = 10.0};
  Grid grid;
  GridStream stream(1, false);
  stream.take(node.fit(10.0), grid);
  for (int number = 0; number < 100; ++number)
    if (number < 40 || number >= 43) stream.take(node.block(number), grid);
  int restarts = 0;
  for (const GridRows& rows : stream.rows.at_hand()) restarts += rows.restart ? 1 : 0;
  EXPECT_EQ(restarts, 2);  // the beginning is one
  EXPECT_NEAR(static_cast<double>(rows_in(stream)), 97.0 * kScansPerBlock - 2 * FractionalDelay::kTaps, 3.0);
  EXPECT_LT(worst_error(stream, grid), 4.0 * kAmplitude * 0.002 * std::numbers::pi / 180.0);
}

// A recorder that begins anew, or a pull: the fit that comes first knows the instant, but hardly the drift,
// and what the node kept meanwhile follows it.
TEST(GridStream, QualityTravelsWithWhateverASampleTouches) {
  const Node node{.offset_s = 3.0, .begin_s = 10.0};
  Grid grid{.origin_ns = 9'999'777'777, .period_ps = 500'000'000};
  GridStream stream(1, false);
  stream.take(node.fit(10.0), grid);
  for (int number = 0; number < 20; ++number) {
    ScanBlock block = node.block(number);
    if (number == 10) {
      block.quality = kQualityNoReference1;
      block.overload = 1 << 3;
    }
    stream.take(block, grid);
  }
  const double first_s = node.host_s(10 * kScansPerBlock), end_s = node.host_s(11 * kScansPerBlock);
  const double reach_s = FractionalDelay::kTaps / 2 / node.rate_hz;
  for (const GridRows& rows : stream.rows.at_hand()) {
    const double begin = 1e-9 * static_cast<double>(grid.time_ns(rows.first_index));
    const double end = 1e-9 * static_cast<double>(grid.time_ns(rows.first_index + rows.rows - 1));
    if (end < first_s - reach_s || begin > end_s + reach_s) {
      EXPECT_EQ(rows.quality, 0);
      EXPECT_EQ(rows.overload, 0);
    }
    if (end > first_s - reach_s + 1e-3 && begin < end_s + reach_s - 1e-3) {
      EXPECT_EQ(rows.quality, kQualityNoReference1);
      EXPECT_EQ(rows.overload, 1 << 3);
    }
  }
}

TEST(GridStream, AnotherRateIsRefusedAndNamed) {
  Grid grid{.origin_ns = 0, .period_ps = 500'000'000};
  GridStream stream(1, false);
  stream.take(Node{.rate_hz = 1000.0}.block(0), grid);
  EXPECT_TRUE(stream.rows.empty());
  EXPECT_NE(stream.refusal().find("another rate"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
