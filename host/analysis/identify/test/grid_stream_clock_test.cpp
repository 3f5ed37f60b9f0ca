#include "host/analysis/identify/grid_stream.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/analysis/identify/test/gridded_node.hpp"

namespace roadbalance {
namespace {

using test::kAmplitude, test::Node, test::rows_in, test::worst_error;

TEST(GridStreamClock, BlocksWaitForTheFirstFit) {
  const Node node{.offset_s = 500.0, .begin_s = 10.0};
  Grid grid;
  GridStream stream(1, false);
  stream.take(node.acquiring(10.0), grid);
  for (int number = 0; number < 600; ++number) stream.take(node.block(number), grid);
  EXPECT_TRUE(stream.rows.empty());
  EXPECT_NE(stream.refusal().find("node 1"), std::string::npos) << stream.refusal();
  stream.take(node.fit(16.0), grid);
  EXPECT_TRUE(stream.refusal().empty());
  EXPECT_EQ(rows_in(stream), 600 * kScansPerBlock - FractionalDelay::kTaps + 1);
  EXPECT_LT(worst_error(stream, grid), 4.0 * kAmplitude * 0.002 * std::numbers::pi / 180.0);
}

TEST(GridStreamClock, AFitThatMovesALittleDoesNotRestart) {
  const Node node{.offset_s = 3.0, .drift = 10e-6, .ppm = 20.0, .begin_s = 10.0};
  Grid grid;
  GridStream stream(1, false);
  int number = 0;
  for (int second = 0; second < 10; ++second) {
    stream.take(node.fit(10.0 + second, second % 2 == 0 ? 5e-6 : -5e-6), grid);
    for (int i = 0; i < 100; ++i) stream.take(node.block(number++), grid);
  }
  for (std::size_t i = 1; i < stream.rows.size(); ++i) {
    ASSERT_FALSE(stream.rows.at_hand()[i].restart);
    ASSERT_EQ(stream.rows.at_hand()[i].first_index,
              stream.rows.at_hand()[i - 1].first_index + stream.rows.at_hand()[i - 1].rows);
  }
  // The fits are 5 us wrong and nothing else is: the steepest slope of the signal over 5 us, and the grid's
  // origin is the first fit's.
  EXPECT_LT(worst_error(stream, grid), kAmplitude * 2.0 * std::numbers::pi * (1 + 18 + 25 + 60) * 16e-6);
}

TEST(GridStreamClock, ABreakOfTheTimeBaseIsNeverSmeared) {
  Node node{.offset_s = 3.0, .begin_s = 10.0};
  Grid grid;
  GridStream stream(1, false);
  stream.take(node.fit(10.0), grid);
  int number = 0;
  for (; number < 100; ++number) stream.take(node.block(number), grid);
  node.offset_s -= 0.7;  // the node's clock is set back; nobody knows yet
  for (; number < 120; ++number) stream.take(node.block(number), grid);
  ClockFit broken = node.fit(11.2);
  broken.state = ClockState::kAcquire;
  broken.breaks = 1;
  stream.take(broken, grid);
  for (; number < 130; ++number) stream.take(node.block(number), grid);
  broken = node.fit(11.3);
  broken.breaks = 1;
  stream.take(broken, grid);
  for (; number < 300; ++number) stream.take(node.block(number), grid);
  EXPECT_EQ(rows_in(stream), 300 * kScansPerBlock - FractionalDelay::kTaps + 1);
  EXPECT_LT(worst_error(stream, grid), 4.0 * kAmplitude * 0.002 * std::numbers::pi / 180.0);
}

TEST(GridStreamClock, AfterAJumpTheRecorderHasTimeToSeeIt) {
  Node node{.offset_s = 3.0, .begin_s = 10.0};
  Grid grid;
  GridStream stream(1, false);
  const ClockFit before = node.fit(10.0);
  const ClockFit late[] = {node.fit(10.9), node.fit(10.95)};
  stream.take(before, grid);
  int number = 0;
  for (; number < 100; ++number) stream.take(node.block(number), grid);
  node.offset_s += 0.2;
  for (; number < 150; ++number) stream.take(node.block(number), grid);
  // A fit that a segment repeats was not made since the jump, nor was one that is only recorded after it.
  for (int repeated = 0; repeated < 5; ++repeated) stream.take(before, grid);
  for (const ClockFit& fit : late) stream.take(fit, grid);
  EXPECT_LE(rows_in(stream), 100 * kScansPerBlock);
  stream.take(node.fit(13.0), grid);  // of a recorder that begins anew and has seen no break
  EXPECT_EQ(rows_in(stream), 150 * kScansPerBlock - FractionalDelay::kTaps + 1);
  EXPECT_LT(worst_error(stream, grid), 4.0 * kAmplitude * 0.002 * std::numbers::pi / 180.0);
}

TEST(GridStreamClock, WhatWasKeptDuringAPullLiesBetweenTheFitsOfBothItsEnds) {
  for (const double pull_s : {15.0, 60.0, 180.0}) {
    const Node node{.offset_s = 3.0, .drift = 40e-6, .ppm = 20.0, .begin_s = 10.0};
    Grid grid;
    GridStream stream(1, false);
    stream.take(node.fit(10.0), grid);
    int number = 0;
    std::int64_t rows = 0;
    double worst = 0.0;
    const auto until = [&](double host_s) {
      for (; node.host_s((number + 1) * kScansPerBlock) < host_s; ++number) {
        stream.take(node.block(number), grid);
        if (number > 5) worst = std::max(worst, worst_error(stream, grid));  // the converter's rate is known
        for (const GridRows& more : stream.rows.at_hand()) EXPECT_EQ(more.restart, rows == 0);
        for (rows += rows_in(stream); !stream.rows.empty();) stream.rows.pop_front();
      }
    };
    until(12.0);
    stream.take(node.acquiring(12.0 + pull_s), grid);
    ClockFit fit = node.fit(12.0 + pull_s);
    fit.drift = 0.0;
    stream.take(fit, grid);
    until(12.0 + pull_s);
    EXPECT_TRUE(stream.refusal().empty()) << pull_s;
    EXPECT_NEAR(static_cast<double>(rows), number * kScansPerBlock, 64.0) << pull_s;
    EXPECT_LT(worst, 4.0 * kAmplitude * 0.002 * std::numbers::pi / 180.0) << pull_s;
  }
}

TEST(GridStreamClock, EpochsThatNeverAnsweredDoNotPushOutOneThatDid) {
  const Node node{.offset_s = 500.0, .begin_s = 10.0};
  Grid grid;
  GridStream stream(1, false);
  stream.take(node.fit(10.0), grid);
  stream.take(node.block(0), grid);
  for (std::int64_t epoch = 100; epoch < 120; ++epoch) {
    ClockFit stranger = node.fit(10.0);
    stranger.epoch = epoch;
    stranger.state = ClockState::kAcquire;
    stream.take(stranger, grid);
  }
  for (int number = 1; number < 100; ++number) stream.take(node.block(number), grid);
  EXPECT_LT(worst_error(stream, grid), 4.0 * kAmplitude * 0.002 * std::numbers::pi / 180.0);
  EXPECT_NEAR(static_cast<double>(rows_in(stream)), 100.0 * kScansPerBlock, 64.0);
}

}  // namespace
}  // namespace roadbalance
