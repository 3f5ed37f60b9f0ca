#include "host/recorder/alarm_watch.hpp"

#include <gtest/gtest.h>

#include "common/bus/channel_faults.hpp"
#include "host/recorder/test/watched_node.hpp"
#include "host/recording/recorded_alarms.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
class AlarmWatchTest : public test::WatchedNode {
 protected:
  AlarmWatchTest() { level.node = 3; }

  Level level;
};

TEST_F(AlarmWatchTest, FindsNothingWhereAllIsWell) {
  for (int k = 0; k < 100; ++k, now += milliseconds(200)) {
    watch.take(beat, now);
    watch.take(level, now);
    watch.take(ClockFit{.node = 3, .epoch = 5, .state = ClockState::kLocked}, now);
    watch.take(Balance{.wheel = 2, .state = Unknown::kTooShort}, now);
    watch.take(RecorderStatus{}, now);
    watch.turn(now);
  }
  EXPECT_EQ(active(), Alarms{});
}

TEST_F(AlarmWatchTest, CountsWhatNodesLose) {
  beat.scans_missing = 30;
  beat.scans_refused = 5;
  beat.encoder_faults = {0, 2};
  watch.take(beat, now);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kSamplesLost, 3}, {AlarmCause::kFaultyTurns, 3, 1}}));
  EXPECT_EQ(watch.active()[0].text, "35 samples by now");
  // A count that goes on unchanged is over; one more begins it again.
  now += seconds(11);
  watch.take(beat, now);
  EXPECT_EQ(watch.due(now).size(), 4u);
  EXPECT_EQ(active(), Alarms{});
  beat.scans_missing = 31;
  watch.take(beat, now);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kSamplesLost, 3}}));
  beat.scans_missing = 4206;
  watch.take(beat, now);
  EXPECT_EQ(watch.active()[0].text, "4211 samples by now");
}

TEST_F(AlarmWatchTest, NamesTheTeethBetweenMarksThatNameNoTooth) {
  beat.mark_counts = {0, 0, 60, 36};
  watch.take(beat, now);
  ASSERT_EQ(active(), (Alarms{{AlarmCause::kWrongMarks, 3, 1}}));
  EXPECT_EQ(watch.active()[0].text.find("60 and 36 teeth lie between its zero marks: is a second magnet"), 0U)
      << watch.active()[0].text;
  EXPECT_EQ(place_of({AlarmCause::kWrongMarks, 3, 1}), "node 3 line 2");
  beat.mark_counts = {95, 0, 0, 0};
  now += seconds(30);
  watch.take(beat, now);
  (void)watch.due(now);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kWrongMarks, 3, 0}}));
}

// Its scans become a gap when it is there again, or at the stop: too late for who could plug it in.
TEST_F(AlarmWatchTest, SaysThatADeviceIsGoneAsLongAsItIs) {
  const auto count = [&](DeviceCounter of) -> auto& {
    return beat.device_counts[static_cast<std::size_t>(of)];
  };
  count(DeviceCounter::kGone) = 3;
  count(DeviceCounter::kReturned) = 2;
  for (int k = 0; k < 600; ++k, now += milliseconds(100)) {
    watch.take(beat, now);
    EXPECT_EQ(watch.due(now).size(), k == 0 ? 1U : 0U);
    EXPECT_EQ(active(), (Alarms{{AlarmCause::kDeviceGone, 3}}));
  }
  count(DeviceCounter::kReturned) = 3;
  now += seconds(11);
  watch.take(beat, now);
  EXPECT_EQ(watch.due(now).size(), 1U);
  EXPECT_EQ(active(), Alarms{});
}

TEST_F(AlarmWatchTest, CountsOneAsOne) {
  beat.scans_missing = 1;
  watch.take(beat, now);
  EXPECT_EQ(watch.active().at(0).text, "1 sample by now");
}

// It is heard, and another recorder's to miss.
TEST_F(AlarmWatchTest, ANodeThatAnotherHasTakenOverIsNotSilent) {
  watch.set_owner(beat.owner = 77);
  watch.take(beat, now);
  beat.owner = 78;
  for (int k = 0; k < 10; ++k, now += std::chrono::seconds(1)) {
    watch.take(beat, now);
    watch.turn(now);
  }
  EXPECT_EQ(active(), Alarms{});
}

TEST_F(AlarmWatchTest, CountsAnewInANewEpoch) {
  beat.scans_missing = 30;
  watch.take(beat, now);
  now += seconds(11);
  (void)watch.due(now);
  beat.epoch = 6;
  beat.scans_missing = 1;
  watch.take(beat, now);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kSamplesLost, 3}}));
}

TEST_F(AlarmWatchTest, MissesANodeThatMeasuresAndNotOneThatHasEnded) {
  now += seconds(3);
  watch.turn(now);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kNodeSilent, 3}}));
  AlarmWatch other(kOurs);
  beat.state = NodeState::kEnded;
  other.take(beat, now);
  other.turn(now + seconds(60));
  EXPECT_TRUE(other.active().empty());
}

TEST_F(AlarmWatchTest, TakesFromTheAnalyserWhatItAloneSees) {
  level.overload = 1U << 4;
  set_dead(level, 2);
  set_railed(level, 15);
  watch.take(level, now);
  watch.take(Balance{.wheel = 1, .state = Unknown::kInStep}, now);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kOverload, 3, 4},
                              {AlarmCause::kDeadChannel, 3, 2},
                              {AlarmCause::kRailedChannel, 3, 15},
                              {AlarmCause::kWheelInStep, 0, 1}}));
}

TEST_F(AlarmWatchTest, ComesBackFromNotes) {
  RecordedAlarms record;
  const auto write = [&](const std::vector<AlarmNote>& notes) {
    for (const AlarmNote& note : notes)
      record.take(
          {.time_us = std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch()).count(),
           .kind = note.began ? NoteKind::kAlarmBegan : NoteKind::kAlarmEnded,
           .a = static_cast<std::int64_t>(note.alarm.cause),
           .b = place_number(note.alarm),
           .text = note.text});
  };
  beat.scans_missing = 35;
  watch.take(beat, now);
  write(watch.due(now));
  now += seconds(11);
  level.overload = 2;
  watch.take(level, now);
  write(watch.due(now));
  ASSERT_EQ(record.all().size(), 2u);
  EXPECT_EQ(sentence(record.all()[0]),
            "ALARM node 3: samples lost (35 samples by now; it lasted 0 s, until 11 s ago)");
  EXPECT_EQ(*record.all()[0].ended_us - record.all()[0].began_us, 11'000'000);
  EXPECT_EQ(sentence(record.all()[1]), "ALARM node 3 channel 2: left its range (no end is recorded)");
  record.take({.kind = NoteKind::kAlarmBegan, .a = 999, .text = "of a later version"});
  EXPECT_EQ(record.all().size(), 2u);
}

TEST_F(AlarmWatchTest, MissesAnAnalyserThatHasSpoken) {
  const auto hear = [&](int halves) {
    for (int k = 0; k < halves; ++k) {
      watch.take(beat, now += milliseconds(500));
      watch.turn(now);
    }
  };
  hear(60);
  EXPECT_EQ(active(), Alarms{}) << "nobody must analyse";
  watch.take(level, now);
  hear(5);
  EXPECT_EQ(active(), Alarms{});
  hear(1);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kAnalyserSilent}}));
  watch.take(level, now);
  now += seconds(11);
  watch.take(beat, now);
  watch.take(level, now);
  EXPECT_EQ(watch.due(now).size(), 2u);
  EXPECT_EQ(active(), Alarms{});
}

TEST_F(AlarmWatchTest, AnAnalyserHasNothingToSayOfASilentNodeAndTimeToSpeakOfOneThatReturns) {
  watch.take(level, now);
  for (int k = 0; k < 20; ++k) watch.turn(now += milliseconds(500));
  watch.take(beat, now);
  watch.turn(now += milliseconds(500));
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kNodeSilent, 3}}));
}

TEST_F(AlarmWatchTest, TellsOfNodesOfAnotherVersionAsLongAsTheySpeak) {
  watch.take_other_version(9, now);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kOtherVersion, 9}}));
  EXPECT_EQ(watch.due(now).size(), 1u);
  EXPECT_EQ(watch.due(now += seconds(11)).size(), 1u);
  EXPECT_EQ(active(), Alarms{});
}

TEST_F(AlarmWatchTest, TakesNothingOfNodesThatObeyAnother) {
  beat.node = level.node = 4;
  beat.owner = kOurs + 1;
  beat.scans_missing = 9;
  level.overload = 1;
  watch.take(beat, now);
  watch.take(level, now);
  EXPECT_EQ(active(), Alarms{});
  AlarmWatch everybody;
  everybody.take(beat, now);
  everybody.take(level, now);
  EXPECT_EQ(everybody.active().size(), 2u);
}

TEST_F(AlarmWatchTest, TakesWhatTheRecorderSaysOfItself) {
  RecorderStatus status;
  status.state = RecorderState::kDiskFull;
  status.on_battery = true;
  watch.take(status, now);
  EXPECT_EQ(active(), (Alarms{{AlarmCause::kDiskFull}, {AlarmCause::kSupplyGone}}));
}

}  // namespace
}  // namespace roadbalance
