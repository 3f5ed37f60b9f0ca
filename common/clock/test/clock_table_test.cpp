#include "common/clock/clock_table.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

ClockFit locked(std::int64_t number, std::int64_t breaks = 0) {
  return {.node = 1,
          .epoch = 7,
          .number = number,
          .state = ClockState::kLocked,
          .host_ns = 1'000 * number,
          .node_ns = 1'000 * number + 5'000,
          .breaks = breaks};
}

ClockFit acquiring(std::int64_t number, std::int64_t breaks = 0) {
  ClockFit fit = locked(number, breaks);
  fit.state = ClockState::kAcquire;
  return fit;
}

const ClockTable::Row& only_row(const ClockTable& table) {
  EXPECT_EQ(table.rows().size(), 1U);
  return table.rows().begin()->second;
}

TEST(ClockTable, WhatASegmentRepeatsSaysNothingNew) {
  ClockTable table;
  EXPECT_TRUE(table.take(locked(1)));
  EXPECT_TRUE(table.take(locked(2)));
  EXPECT_FALSE(table.take(locked(2)));
  EXPECT_TRUE(table.take(locked(3))) << "one fit like another is still another";
}

// A recorder that was started again asks anew, and counts its fits from 1.
TEST(ClockTable, WhatWasKnownHoldsWhileARecorderThatHasJustBegunKnowsNothing) {
  ClockTable table;
  ClockFit first = acquiring(51), second = locked(52);
  first.number = 1;
  second.number = 2;
  EXPECT_TRUE(table.take(locked(50)));
  EXPECT_TRUE(table.take(first));
  EXPECT_EQ(only_row(table).known.last(), locked(50));
  EXPECT_EQ(only_row(table).last, first);
  EXPECT_FALSE(table.take(locked(50)));
  EXPECT_FALSE(table.take(first));
  EXPECT_EQ(only_row(table).last, first) << "the repetition has changed nothing";
  EXPECT_TRUE(table.take(second));
  EXPECT_EQ(only_row(table).known.last(), second);
}

// A folder in which a recorder went on begins with fits of the one before, and repeats some of them.
TEST(ClockTable, AFitOfBeforeSaysNothingNew) {
  ClockTable table;
  table.take(locked(49));
  table.take(locked(50));
  EXPECT_FALSE(table.take(locked(10)));
  EXPECT_FALSE(table.take(acquiring(10)));
  EXPECT_TRUE(table.take(acquiring(51)));
  EXPECT_FALSE(table.take(locked(49)));
  EXPECT_EQ(only_row(table).known.fits(), (std::vector{locked(49), locked(50)}));
  EXPECT_EQ(only_row(table).last, acquiring(51));
  EXPECT_FALSE(table.take(acquiring(50)));
}

TEST(ClockTable, NorDoesOneOfBeforeABreak) {
  ClockTable table;
  table.take(locked(50));
  table.take(acquiring(51, 1));
  EXPECT_FALSE(table.take(locked(50)));
  EXPECT_FALSE(only_row(table).known.is_known());
}

TEST(ClockTable, AClockThatBeganAnewIsNotOneOfBefore) {
  ClockTable table;
  table.take(locked(50));
  ClockFit booted = locked(51);
  booted.host_ns = 20;
  EXPECT_TRUE(table.take(booted)) << "the host's";
  ClockFit set_back = locked(52, 1);
  set_back.host_ns = 1'020;
  set_back.node_ns = 7;
  EXPECT_TRUE(table.take(set_back)) << "the node's";
  EXPECT_EQ(only_row(table).known.last(), set_back);
}

TEST(ClockTable, NothingIsKnownBehindABreakUntilTheNextFit) {
  ClockTable table;
  table.take(locked(50));
  EXPECT_TRUE(table.take(acquiring(51, 1)));
  EXPECT_FALSE(only_row(table).known.is_known());
  EXPECT_TRUE(table.take(locked(52, 1)));
  EXPECT_EQ(only_row(table).known.last(), locked(52, 1));
}

TEST(ClockTable, TakesTheFirstOfAnEpochWhateverItSays) {
  ClockTable table;
  EXPECT_TRUE(table.take(acquiring(-9)));
  EXPECT_EQ(only_row(table).last, acquiring(-9));
}

TEST(ClockTable, ForgetsTheEpochThatWasHeardOfLongestAgo) {
  ClockTable table;
  for (std::size_t k = 0; k <= ClockTable::kMostClocks; ++k) {
    ClockFit fit = locked(static_cast<std::int64_t>(k) + 1);
    fit.epoch = static_cast<std::int64_t>(1000 - k);
    table.take(fit);
  }
  EXPECT_EQ(table.rows().size(), ClockTable::kMostClocks);
  EXPECT_FALSE(table.rows().contains({1, 1000}));
  EXPECT_TRUE(table.rows().contains({1, 999}));
}

}  // namespace
}  // namespace roadbalance
