#include "host/recording/recorded_alarms.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

constexpr int kMillion = 1'000'000;
constexpr std::size_t kKept = RecordedAlarms::kMostOfALevel;

Note note_of(NoteKind kind, const Alarm& alarm, std::int64_t time_us, const char* text = "") {
  return {.time_us = time_us,
          .kind = kind,
          .a = static_cast<std::int64_t>(alarm.cause),
          .b = place_number(alarm),
          .text = text};
}

class RecordedAlarmsTest : public ::testing::Test {
 protected:
  void begin(const Alarm& alarm, std::int64_t time_us) {
    record.take(note_of(NoteKind::kAlarmBegan, alarm, time_us));
  }
  void end(const Alarm& alarm, std::int64_t time_us, const char* text = "") {
    record.take(note_of(NoteKind::kAlarmEnded, alarm, time_us, text));
  }
  RecordedAlarms record;
};

TEST_F(RecordedAlarmsTest, GivesEachEndToTheLastBeginOfTheSame) {
  const Alarm loss{AlarmCause::kSamplesLost, 1}, other{AlarmCause::kSamplesLost, 2};
  begin(loss, 1);  // killed before its end
  begin(loss, 2);
  begin(other, 3);
  end(loss, 4, "of the second");
  end(loss, 5, "of nothing");
  ASSERT_EQ(record.all().size(), 3u);
  EXPECT_EQ(record.all()[0].ended_us, std::nullopt);
  EXPECT_EQ(record.all()[1].ended_us, 4);
  EXPECT_EQ(record.all()[1].text, "of the second");
  EXPECT_EQ(record.all()[2].ended_us, std::nullopt);
}

// Half a million notes: a search through all for each would never end.
TEST_F(RecordedAlarmsTest, TakesAMillionThatBeginAndEndInBoundedMemory) {
  for (int k = 1; k <= kMillion; ++k) begin({AlarmCause::kSamplesLost, k}, k);
  for (int k = 1; k <= kMillion; ++k) end({AlarmCause::kSamplesLost, k}, kMillion + k);
  EXPECT_EQ(record.all().size(), kKept);
  EXPECT_EQ(record.left_out(), kMillion - kKept);
  EXPECT_EQ(record.all().front().ended_us, kMillion + 1);
  EXPECT_EQ(record.all().back().ended_us, kMillion + static_cast<std::int64_t>(kKept));
}

TEST_F(RecordedAlarmsTest, AFloodOfNoticesHidesNoAlarm) {
  for (int k = 1; k <= kMillion; ++k) begin({AlarmCause::kWheelInStep, 0, k % 4}, k);
  begin({AlarmCause::kSamplesLost, 1}, kMillion + 1);
  EXPECT_EQ(record.all().size(), kKept + 1);
  EXPECT_EQ(record.all().back().alarm, (Alarm{AlarmCause::kSamplesLost, 1}));
}

TEST_F(RecordedAlarmsTest, TheEndOfOneThatIsLeftOutEndsNoOther) {
  for (std::size_t k = 0; k < kKept; ++k) begin({AlarmCause::kWheelInStep, 0, 2}, 1);
  begin({AlarmCause::kWheelInStep, 0, 2}, 2);
  end({AlarmCause::kWheelInStep, 0, 2}, 3);
  EXPECT_EQ(record.left_out(), 1u);
  for (const RecordedAlarm& one : record.all()) ASSERT_EQ(one.ended_us, std::nullopt);
}

// The second began before the clock was set and ended behind it.
TEST_F(RecordedAlarmsTest, MoveWithTheClockThatIsSet) {
  begin({AlarmCause::kSamplesLost, 1}, 10);
  end({AlarmCause::kSamplesLost, 1}, 20);
  begin({AlarmCause::kDiskFull}, 30);
  record.take({.time_us = 1'000'040, .kind = NoteKind::kClockSet, .a = 1'000'000, .text = {}});
  end({AlarmCause::kDiskFull}, 1'000'050);
  const std::vector<RecordedAlarm> all = record.all();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].began_us, 1'000'010);
  EXPECT_EQ(all[0].ended_us, 1'000'020);
  EXPECT_EQ(all[1].began_us, 1'000'030);
  EXPECT_EQ(all[1].ended_us, 1'000'050);
}

TEST_F(RecordedAlarmsTest, PassesOverWhatIsNoAlarmOfThisVersion) {
  record.take({.kind = NoteKind::kAlarmBegan, .a = 999, .b = -7, .text = "of a later version"});
  record.take(note_of(NoteKind::kMark, {AlarmCause::kDiskFull}, 1));
  end({AlarmCause::kDiskFull}, 2);
  EXPECT_TRUE(record.all().empty());
}

}  // namespace
}  // namespace roadbalance
