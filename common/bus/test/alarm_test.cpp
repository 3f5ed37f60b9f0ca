#include "common/bus/alarm.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace roadbalance {
namespace {

TEST(Alarm, HasOneOfThreeLevelsAndWordsOfItsOwn) {
  std::set<std::string> names;
  int causes = 0;
  for (std::int64_t number = -1000; number < 2000; ++number) {
    if (!is_alarm_cause(number)) continue;
    ++causes;
    const auto cause = static_cast<AlarmCause>(number);
    const auto level = static_cast<std::int32_t>(level_of(cause));
    EXPECT_TRUE(level >= 1 && level <= 3) << number;
    names.insert(name_of(cause));
  }
  EXPECT_EQ(std::ssize(names), causes) << "no two say the same";
  EXPECT_GT(causes, 20);
  EXPECT_EQ(level_of(AlarmCause::kSamplesLost), AlarmLevel::kAlarm);
  EXPECT_EQ(level_of(AlarmCause::kDeadChannel), AlarmLevel::kWarning);
  EXPECT_EQ(level_of(AlarmCause::kWheelInStep), AlarmLevel::kNotice);
  std::set<std::string> shapes;
  for (const AlarmLevel level : {AlarmLevel::kNotice, AlarmLevel::kWarning, AlarmLevel::kAlarm})
    shapes.insert(shape(level));
  EXPECT_EQ(shapes.size(), 3u) << "told apart without colours";
}

TEST(Alarm, NamesItsPlaceAsTheMarkingsDo) {
  EXPECT_EQ(place_of({AlarmCause::kDiskFull}), "");
  EXPECT_EQ(place_of({AlarmCause::kSamplesLost, 3}), "node 3");
  EXPECT_EQ(place_of({AlarmCause::kOverload, 2, 0}), "node 2 channel 1");
  EXPECT_EQ(place_of({AlarmCause::kFaultyTurns, 1, 1}), "node 1 line 2");
  EXPECT_EQ(place_of({AlarmCause::kWheelInStep, 0, 1}), "front right");
}

TEST(Alarm, SaysLevelPlaceNameAndHowMuch) {
  EXPECT_EQ(sentence_of({AlarmCause::kDiskFull}), "ALARM: disk full");
  EXPECT_EQ(sentence_of({AlarmCause::kSamplesLost, 3}, "35 samples by now"),
            "ALARM node 3: samples lost (35 samples by now)");
  EXPECT_EQ(sentence_of({AlarmCause::kDeadChannel, 2, 0}), "WARNING node 2 channel 1: no signal");
}

TEST(Alarm, ComesBackFromTheNumbersOfANote) {
  for (const Alarm alarm :
       {Alarm{AlarmCause::kDiskFull}, Alarm{AlarmCause::kSamplesLost, 7}, Alarm{AlarmCause::kOverload, 12, 0},
        Alarm{AlarmCause::kOverload, 63, 15}, Alarm{AlarmCause::kWheelInStep, 0, 3}}) {
    const Alarm back = alarm_of(static_cast<std::int64_t>(alarm.cause), place_number(alarm));
    EXPECT_EQ(back, alarm) << place_of(alarm);
  }
}

}  // namespace
}  // namespace roadbalance
