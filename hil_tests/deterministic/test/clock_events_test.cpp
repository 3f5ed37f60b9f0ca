#include "hil_tests/deterministic/clock_events.hpp"

#include <gtest/gtest.h>

#include "common/bus/clock_messages.hpp"
#include "common/bus/notes.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

// A record that begins with five events, one a second, of which the second and the fourth are fits.
class ClockEventsTest : public ::testing::Test {
 protected:
  using Message = std::pair<std::string, std::vector<std::uint8_t>>;

  ClockEventsTest() {
    for (int k = 1; k <= 5; ++k) give(event(k));
    begin_segment();
  }
  // Off the line through the others by what the drift of a crystal allows.
  static Message fit(int k, std::int64_t epoch = 7, std::int64_t off_ns = 0) {
    const ClockFit fit{.node = 1,
                       .epoch = epoch,
                       .state = ClockState::kLocked,
                       .host_ns = k * kSecond_ns,
                       .node_ns = k * kSecond_ns + off_ns};
    return {clock_fit_channel(1), encode(fit)};
  }
  static Message exchange(int k) {
    return {clock_exchange_channel(1), encode(ClockExchange{.node = 1, .epoch = 7, .number = k})};
  }
  static Message event(int k) { return k % 2 == 0 ? fit(k) : exchange(k); }

  void give(const Message& message) { events.given(message.first, message.second); }
  void take(const Message& message) { events.take(message.first, message.second); }
  void take(std::initializer_list<int> recorded) {
    for (const int k : recorded) take(event(k));
  }
  void begin_segment() {
    events.begin_segment(++segment, [this](const NodeEpoch& key) { return key.second == ended_epoch; });
  }
  std::int64_t faults_of(std::initializer_list<int> recorded, std::size_t durable) {
    events.durable(durable);
    take(recorded);
    events.finish();
    return truth.fault_count();
  }
  std::int64_t faults() {
    events.finish();
    return truth.fault_count();
  }

  int segment = 0;
  std::int64_t ended_epoch = 0;
  Truth truth;
  ClockEvents events{truth};
};

TEST_F(ClockEventsTest, AllInOrderIsWhatWasGiven) {
  EXPECT_EQ(faults_of({1, 2, 3, 4, 5}, 5), 0);
  EXPECT_EQ(events.found(), 5);
}
TEST_F(ClockEventsTest, WhatWasNotDurableMayBeGone) {
  EXPECT_EQ(faults_of({1, 2, 4}, 2), 0);
}
TEST_F(ClockEventsTest, WhatWasDurableMayNot) {
  EXPECT_EQ(faults_of({1, 2, 4}, 5), 2);
}
TEST_F(ClockEventsTest, WhatDiedWithARecorderIsNotDurableBecauseLaterEventsAre) {
  events.durable(2);
  events.died();
  give(event(6));
  events.durable(6);
  EXPECT_EQ(faults_of({1, 2, 4, 6}, 6), 0);
}
TEST_F(ClockEventsTest, AnExchangeStandsThereOnce) {
  EXPECT_EQ(faults_of({1, 2, 3, 3, 4, 5}, 5), 1);
}
TEST_F(ClockEventsTest, NothingComesLate) {
  EXPECT_EQ(faults_of({1, 2, 4, 3, 5}, 0), 1);
}
TEST_F(ClockEventsTest, NothingComesThatNobodyGave) {
  EXPECT_EQ(faults_of({1, 2, 6}, 0), 1);
}

TEST_F(ClockEventsTest, NorAFitThatReadersTakeForAnEarlierOne) {
  give(fit(3));
  take({1, 2, 3, 4, 5});
  EXPECT_EQ(truth.fault_count(), 0);
  take(fit(3));
  EXPECT_EQ(faults(), 1);
}

TEST_F(ClockEventsTest, ASegmentSaysFitsAgain) {
  take({1, 2});
  begin_segment();
  take({2, 3, 4});
  begin_segment();
  take({2, 4, 5});
  EXPECT_EQ(faults(), 0);
}
TEST_F(ClockEventsTest, InItsPreambleOnly) {
  for (const int k : {3, 4}) {
    SCOPED_TRACE(k);
    ClockEvents record{truth};
    const std::int64_t before = truth.fault_count();
    record.begin_segment(1, [](const NodeEpoch&) { return false; });
    for (const Message& message : {fit(2), event(k)}) record.given(message.first, message.second);
    record.take(fit(2).first, fit(2).second);
    record.begin_segment(2, [](const NodeEpoch&) { return false; });
    for (const Message& message : {event(k), fit(2)}) record.take(message.first, message.second);
    EXPECT_EQ(truth.fault_count() - before, 2) << "the preamble lacks it, too";
  }
}
TEST_F(ClockEventsTest, AndThePairOfClocks) {
  const auto note = [](std::int64_t s) {
    return Message{kNoteChannel, encode(Note{.time_us = 1'000'000 * s,
                                             .host_ns = s * kSecond_ns,
                                             .incarnation = 3,
                                             .kind = NoteKind::kClock,
                                             .text = {}})};
  };
  for (const std::int64_t s : {1, 2}) take(note(s));
  begin_segment();
  take(note(2));
  EXPECT_EQ(faults(), 0);
  begin_segment();
  take(note(3));
  EXPECT_EQ(faults(), 1);
  segment = 0;  // another record
  begin_segment();
  EXPECT_EQ(faults(), 1);
}
TEST_F(ClockEventsTest, EachOnce) {
  take({1, 2, 3, 4});
  begin_segment();
  take({2, 4, 4});
  EXPECT_EQ(truth.fault_count(), 1);
}
TEST_F(ClockEventsTest, OfThoseThatTheRecordHolds) {
  take({1, 4});
  begin_segment();
  take({2, 4});
  EXPECT_EQ(truth.fault_count(), 1);
}
TEST_F(ClockEventsTest, EachThatPlacesWhatComes) {
  take({1, 2, 3, 4});
  begin_segment();
  take({4, 5});
  EXPECT_EQ(truth.fault_count(), 1);
  EXPECT_EQ(faults(), 1) << "as far as that one goes an instant is placed as before";
}
TEST_F(ClockEventsTest, ButForEpochsThatHaveEnded) {
  take({1, 2});
  ended_epoch = 7;
  begin_segment();
  give(fit(6, 8));
  take(fit(6, 8));
  begin_segment();
  take(fit(6, 8));
  give(fit(7, 7, 100'000));
  take(fit(7, 7, 100'000));
  EXPECT_EQ(faults(), 0) << "it may have another fit, but nothing comes that it would place";
  begin_segment();
  take({2});
  EXPECT_EQ(truth.fault_count(), 1);
}

// Both sides of a hole, and the last one.
TEST_F(ClockEventsTest, InTheOrderInWhichTheyCame) {
  const Message hole_end = fit(40, 7, 100'000);
  give(hole_end);
  give(fit(41));
  take({1, 2, 3, 4, 5});
  take(hole_end);
  take(fit(41));
  begin_segment();
  for (const Message& message : {fit(4), hole_end, fit(41)}) take(message);
  begin_segment();
  EXPECT_EQ(truth.fault_count(), 0);
  for (const Message& message : {hole_end, fit(41), fit(4)}) take(message);
  EXPECT_EQ(faults(), 1);
}

}  // namespace
}  // namespace roadbalance::test
