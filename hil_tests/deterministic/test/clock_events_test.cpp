#include "hil_tests/deterministic/clock_events.hpp"

#include <gtest/gtest.h>

namespace roadbalance::test {
namespace {

const std::string kFit = "RB_CLOCK_1", kExchange = "RB_CLOCK_EXCHANGE_1";

// Five events, of which the second and the fourth are fits.
class ClockEventsTest : public ::testing::Test {
 protected:
  ClockEventsTest() {
    for (std::uint8_t k = 1; k <= 5; ++k) events.given(channel(k), {k});
  }
  static const std::string& channel(std::uint8_t k) { return k % 2 == 0 ? kFit : kExchange; }
  std::int64_t faults_of(const std::vector<std::uint8_t>& recorded, std::size_t durable) {
    events.durable(durable);
    for (const std::uint8_t k : recorded) events.take(channel(k), std::span(&k, 1));
    events.finish();
    return truth.fault_count();
  }

  Truth truth;
  ClockEvents events{truth};
};

TEST_F(ClockEventsTest, AllInOrderIsWhatWasGiven) {
  EXPECT_EQ(faults_of({1, 2, 3, 4, 5}, 5), 0);
  EXPECT_EQ(events.found(), 5);
}
TEST_F(ClockEventsTest, ASegmentSaysTheLastFitAgain) {
  EXPECT_EQ(faults_of({1, 2, 2, 3, 2, 4, 4, 5}, 5), 0);
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
  const std::string& more = channel(6);
  events.given(more, {6});
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

}  // namespace
}  // namespace roadbalance::test
