#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "host/recorder/test/watched_node.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A recorder asks the node for its time, and hears it twice a second.
class ClockAlarmTest : public test::WatchedNode {
 protected:
  ClockAlarmTest() {
    beat.time_base = TimeBase::kOwn;
    watch.take(beat, now);
  }
  void go(double for_s, std::optional<ClockFit> fit) {
    for (const WallTime end = now + milliseconds(static_cast<int>(1e3 * for_s)); now < end;) {
      now += milliseconds(500);
      watch.take(beat, now);
      if (fit) watch.take(*fit, now);
      watch.turn(now);
      for (const AlarmNote& note : watch.due(now)) notes.push_back(note);
    }
  }
  static ClockFit fit(double uncertainty_s, ClockState state = ClockState::kLocked) {
    return {.node = 3, .epoch = 5, .state = state, .uncertainty_s = uncertainty_s};
  }

  std::vector<AlarmNote> notes;
};

TEST_F(ClockAlarmTest, AClockThatIsNeverHeardIsMissedAndItsReturnEndsThat) {
  go(9.5, std::nullopt);
  EXPECT_EQ(active(), Alarms{}) << "it has its time to become known";
  go(1, std::nullopt);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kClockUnheard, 3}}));
  go(11, fit(10e-6));
  EXPECT_EQ(active(), Alarms{});
  ASSERT_EQ(notes.size(), 2u) << "begin and end";
  EXPECT_TRUE(notes[0].began && !notes[1].began);
}

TEST_F(ClockAlarmTest, AClockThatIsAskedAndNeverAnswersIsMissed) {
  go(11, fit(0, ClockState::kAcquire));
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kClockUnheard, 3}}));
  EXPECT_EQ(watch.active()[0].text, "look at its network");
}

TEST_F(ClockAlarmTest, AClockThatAnswersTooRarelyIsMissedForThat) {
  ClockFit rare = fit(0, ClockState::kAcquire);
  rare.exchanges = 1;
  go(8, rare);
  rare.exchanges = 2;
  go(3, rare);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kClockUnheard, 3}}));
  EXPECT_EQ(watch.active()[0].text, "it answers, too rarely to be known: look at its network");
  go(10, rare);
  EXPECT_EQ(watch.active()[0].text, "look at its network") << "no more";
}

TEST_F(ClockAlarmTest, AFitOfAnEpochThatIsOverTellsNothing) {
  ClockFit old = fit(10e-6);
  old.epoch = 4;
  go(11, old);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kClockUnheard, 3}}));
}

TEST_F(ClockAlarmTest, ClocksOfASimulationAndOfNodesThatNobodyRecordsAreNotAsked) {
  beat.time_base = TimeBase::kShared;
  go(30, std::nullopt);
  EXPECT_EQ(active(), Alarms{});
  AlarmWatch everybody;
  beat.time_base = TimeBase::kOwn;
  beat.owner = 0;
  everybody.take(beat, now);
  now += seconds(60);
  everybody.take(beat, now);
  everybody.turn(now);
  EXPECT_TRUE(everybody.active().empty());
}

TEST_F(ClockAlarmTest, AClockMayBecomeWellKnownAndMustStaySo) {
  go(9, fit(400e-6));
  EXPECT_EQ(active(), Alarms{});
  go(5, fit(50e-6));
  EXPECT_EQ(active(), Alarms{}) << "so much is wanted";
  go(0.5, fit(120.2e-6));
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kClockPoor, 3}}));
  EXPECT_EQ(watch.active()[0].text, "121 us, 50 us are wanted");
  go(11, fit(20e-6));
  EXPECT_EQ(active(), Alarms{});
  EXPECT_EQ(notes.size(), 2u);
}

TEST_F(ClockAlarmTest, AClockThatNeverBecomesWellKnownIsToldOnceItsTimeIsOver) {
  go(11, fit(400e-6));
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kClockPoor, 3}}));
  beat.epoch = 6;
  ClockFit next = fit(400e-6);
  next.epoch = 6;
  go(9, next);
  EXPECT_EQ(notes.size(), 1u);
  go(3, next);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kClockPoor, 3}})) << "a new epoch has its time again";
}

TEST_F(ClockAlarmTest, ASilentNodeIsNotSaidToHaveNoClockBesides) {
  go(5, fit(10e-6));
  for (int k = 0; k < 60; ++k) watch.turn(now += milliseconds(500));
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kNodeSilent, 3}}));
}

}  // namespace
}  // namespace roadbalance
