#include "host/recording/recover/recovered_clocks.hpp"

#include <gtest/gtest.h>

#include "common/bus/clock_messages.hpp"
#include "common/bus/notes.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kAhead_ns = 5 * kSecond_ns;  // by which the node's clock is ahead of the host's

class RecoveredClocksTest : public ::testing::Test {
 protected:
  bool takes_fit(std::int64_t s) {
    const ClockFit fit{.node = 1,
                       .epoch = 7,
                       .state = ClockState::kLocked,
                       .host_ns = s * kSecond_ns,
                       .node_ns = s * kSecond_ns + kAhead_ns};
    return clocks.is_new(clock_fit_channel(1), encode(fit));
  }
  bool takes_exchange(std::int64_t s, std::int64_t ahead_ns = kAhead_ns, std::int64_t epoch = 7) {
    const std::int64_t host_ns = s * kSecond_ns;
    const ClockExchange exchange{.node = 1,
                                 .epoch = epoch,
                                 .number = 1,
                                 .asked_ns = host_ns,
                                 .received_ns = host_ns + ahead_ns,
                                 .answered_ns = host_ns + ahead_ns,
                                 .heard_ns = host_ns};
    return clocks.is_new(clock_exchange_channel(1), encode(exchange));
  }

  RecoveredClocks clocks;
};

TEST_F(RecoveredClocksTest, WhatTheOtherFolderSaysAgainIsNotNew) {
  EXPECT_TRUE(takes_exchange(10));
  EXPECT_TRUE(takes_fit(10));
  EXPECT_TRUE(takes_exchange(11));
  EXPECT_TRUE(takes_fit(11));
  EXPECT_TRUE(takes_exchange(12));
  // A segment begins with fits, and events that may not have reached the first folder follow.
  for (const std::int64_t s : {10, 11}) EXPECT_FALSE(takes_fit(s));
  for (const std::int64_t s : {11, 12}) EXPECT_FALSE(takes_exchange(s));
  EXPECT_TRUE(takes_exchange(13));
  EXPECT_TRUE(takes_fit(13));
}

TEST_F(RecoveredClocksTest, NothingIsLostThatComesOutOfOrder) {
  for (const std::int64_t s : {10, 12, 11, 3}) {
    EXPECT_TRUE(takes_exchange(s))
        << "an answer may overtake the one before, a folder come before the first one";
    EXPECT_TRUE(takes_fit(s));
  }
}

TEST_F(RecoveredClocksTest, ClocksThatBeginAnewAreNew) {
  EXPECT_TRUE(takes_exchange(100));
  EXPECT_TRUE(takes_exchange(100, kAhead_ns, 8)) << "another epoch";
  EXPECT_TRUE(takes_exchange(101, kAhead_ns - kSecond_ns)) << "the node's was set back, to the same instant";
  EXPECT_TRUE(takes_exchange(100, 60 * kSecond_ns)) << "the host was booted, and as old again";
  EXPECT_FALSE(takes_exchange(100, 60 * kSecond_ns));
}

TEST_F(RecoveredClocksTest, OtherEventsGoAlong) {
  for (int k = 0; k < 2; ++k)
    EXPECT_TRUE(clocks.is_new(kNoteChannel, encode(Note{.kind = NoteKind::kMark, .text = "bump"})));
}

}  // namespace
}  // namespace roadbalance
