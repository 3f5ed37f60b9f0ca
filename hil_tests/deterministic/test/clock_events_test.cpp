#include "hil_tests/deterministic/clock_events.hpp"

#include <gtest/gtest.h>

#include "common/bus/clock_messages.hpp"

namespace roadbalance::test {
namespace {

// A record of one segment, of five events, of which the second and the fourth are fits.
class ClockEventsTest : public ::testing::Test {
 protected:
  ClockEventsTest() {
    for (int k = 1; k <= 5; ++k) give(k);
  }
  // An exchange, or a fit; the host's second is their number.
  static std::pair<std::string, std::vector<std::uint8_t>> event(int k,
                                                                 ClockState state = ClockState::kLocked,
                                                                 std::int64_t epoch = 7) {
    const std::int64_t host_ns = k * std::int64_t{1'000'000'000};
    if (k % 2 != 0) {
      const ClockExchange exchange{.node = 1, .epoch = epoch, .number = k, .asked_ns = host_ns};
      return {clock_exchange_channel(1), encode(exchange)};
    }
    const ClockFit fit{
        .node = 1, .epoch = epoch, .number = k, .state = state, .host_ns = host_ns, .node_ns = host_ns};
    return {clock_fit_channel(1), encode(fit)};
  }
  void give(int k, ClockState state = ClockState::kLocked, std::int64_t epoch = 7) {
    const auto [channel, bytes] = event(k, state, epoch);
    events.given(channel, bytes);
  }
  void take(int segment, std::initializer_list<int> recorded, ClockState state = ClockState::kLocked,
            std::int64_t epoch = 7) {
    for (const int k : recorded) {
      const auto [channel, bytes] = event(k, state, epoch);
      events.take(segment, channel, bytes);
    }
  }
  std::int64_t faults_of(std::initializer_list<int> recorded, std::size_t durable) {
    events.durable(durable);
    take(1, recorded);
    events.finish();
    return truth.fault_count();
  }
  // Whether the second segment, behind the fits of these seconds, may begin with those.
  static bool may_begin_with(std::initializer_list<int> fits, std::initializer_list<int> again) {
    Truth none;
    ClockEvents record{none};
    for (const int k : fits) {
      const auto [channel, bytes] = event(k);
      record.given(channel, bytes);
      record.take(1, channel, bytes);
    }
    for (const int k : again) {
      const auto [channel, bytes] = event(k);
      record.take(2, channel, bytes);
    }
    return none.fault_count() == 0;
  }

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
  give(6);
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

TEST_F(ClockEventsTest, ASegmentSaysFitsAgainAtItsBeginningOnly) {
  take(1, {1, 2});
  take(2, {2, 3, 4});
  take(3, {2, 5});
  EXPECT_EQ(truth.fault_count(), 0);
  take(3, {4});
  EXPECT_EQ(truth.fault_count(), 1) << "an exchange ends the beginning";
  take(4, {4});
  EXPECT_EQ(truth.fault_count(), 1);
  take(4, {4});
  EXPECT_EQ(truth.fault_count(), 2) << "twice in one segment";
}
TEST_F(ClockEventsTest, ASegmentSaysNothingAgainThatIsNotInTheRecord) {
  give(6);
  take(1, {1, 4, 5, 6});
  take(2, {4, 6});
  EXPECT_EQ(truth.fault_count(), 0);
  take(3, {2});
  EXPECT_EQ(truth.fault_count(), 1);
}
TEST_F(ClockEventsTest, NorThatItBeginsWithItself) {
  take(1, {1, 2, 3});
  take(2, {4, 4});
  EXPECT_EQ(truth.fault_count(), 1);
}
TEST_F(ClockEventsTest, OfAnEpochTheLastTwoAreSaidAgain) {
  EXPECT_TRUE(may_begin_with({2, 4, 6}, {4, 6}));
  EXPECT_FALSE(may_begin_with({100, 102, 104}, {100}));
  EXPECT_TRUE(may_begin_with({2, 4, 6, 50}, {6, 50}));
  EXPECT_FALSE(may_begin_with({2, 4, 6, 50}, {4}));
}
TEST_F(ClockEventsTest, AndForAMinuteBothSidesOfAHole) {
  EXPECT_TRUE(may_begin_with({100, 102, 110, 112, 114, 168}, {102, 110, 168}));
  EXPECT_FALSE(may_begin_with({100, 102, 110, 112, 114, 168}, {100}));
  EXPECT_FALSE(may_begin_with({100, 102, 110, 112, 114, 168}, {112}));
  EXPECT_FALSE(may_begin_with({100, 102, 110, 112, 114, 168, 170}, {102})) << "it ended a minute ago";
  EXPECT_FALSE(may_begin_with({100, 102, 110, 112, 114, 168, 170}, {110}));
  EXPECT_TRUE(may_begin_with({100, 102, 110, 112, 114, 168, 170}, {114, 168})) << "another";
}
TEST_F(ClockEventsTest, FitsThatKnowNothingAndOtherEpochsPushNoneOut) {
  take(1, {1, 2, 3, 4, 5});
  for (const int k : {6, 8}) {
    give(k, ClockState::kAcquire);
    take(1, {k}, ClockState::kAcquire);
  }
  for (const int k : {10, 12, 14}) {
    give(k, ClockState::kLocked, 8);
    take(1, {k}, ClockState::kLocked, 8);
  }
  take(2, {2, 4});
  take(2, {8}, ClockState::kAcquire);
  take(2, {12, 14}, ClockState::kLocked, 8);
  EXPECT_EQ(truth.fault_count(), 0);
  take(2, {6}, ClockState::kAcquire);
  EXPECT_EQ(truth.fault_count(), 1) << "the last one only";
}

}  // namespace
}  // namespace roadbalance::test
