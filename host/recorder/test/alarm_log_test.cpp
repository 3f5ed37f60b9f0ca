#include "host/recorder/alarm_log.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
constexpr Alarm kLost{AlarmCause::kSamplesLost, 1};
constexpr Alarm kOver{AlarmCause::kOverload, 1, 4};

class AlarmLogTest : public ::testing::Test {
 protected:
  AlarmLog log;
  WallTime now{seconds(1000)};
};

TEST_F(AlarmLogTest, SaysOnceThatItBeganAndOnceThatItIsOver) {
  std::vector<AlarmNote> notes;
  for (int k = 0; k < 300; ++k, now += milliseconds(100)) {  // it lasts half of that
    if (k < 150) log.raise(kLost, std::to_string(35 + k) + " samples", now);
    if (k == 100) {
      EXPECT_EQ(log.active().at(0).text, "135 samples") << "what it has come to";
    }
    for (const auto& note : log.due(now)) notes.push_back(note);
    EXPECT_EQ(log.active().size(), k < 250 - 1 ? 1u : 0u) << k;
  }
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_TRUE(notes[0].began);
  EXPECT_EQ(notes[0].alarm, kLost);
  EXPECT_EQ(notes[0].text, "35 samples");
  EXPECT_FALSE(notes[1].began);
  EXPECT_EQ(notes[1].text, "184 samples; it lasted 14 s, until 10 s ago");
}

TEST_F(AlarmLogTest, BoundsWhatAnAlarmThatFlapsWrites) {
  // It comes each 11 s, which is just over the hold; and, worst, as soon as each hold is over.
  int each_11_s = 0, worst = 0;
  AlarmLog other;
  for (int s = 0; s < 8 * 3600; ++s, now += seconds(1)) {
    if (s % 11 == 0) log.raise(kOver, "", now);
    if (other.active().empty()) other.raise(kOver, "", now);
    each_11_s += static_cast<int>(log.due(now).size());
    worst += static_cast<int>(other.due(now).size());
  }
  EXPECT_LE(each_11_s, 3) << "from the second time on it is one alarm";
  EXPECT_GT(worst, 60) << "it was told of";
  EXPECT_LE(worst, 2 * (7 + 8 * 3600 / 640)) << "two notes a hold";
}

TEST_F(AlarmLogTest, KeepsForLaterWhatTheDiskDidNotTake) {
  log.raise(kLost, "35 samples", now);
  now += seconds(60);
  const auto notes = log.due(now);
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_EQ(notes[0].text, "35 samples, 60 s ago");
  EXPECT_EQ(notes[1].text, "35 samples; it lasted 0 s, until 60 s ago");
}

TEST_F(AlarmLogTest, EndsWithTheRecording) {
  log.raise(kOver, "", now);
  EXPECT_EQ(log.due(now).size(), 1u);
  now += seconds(2);
  log.raise(kLost, "", now);
  const auto notes = log.finish(now);
  ASSERT_EQ(notes.size(), 3u) << "one begins and both end";
  EXPECT_TRUE(log.active().empty());
  EXPECT_TRUE(log.finish(now).empty());
}

TEST_F(AlarmLogTest, ShowsTheWorstFirstAndHasABound) {
  log.raise({AlarmCause::kWheelInStep, 0, 1}, "", now);
  log.raise({AlarmCause::kDeadChannel, 1, 1}, "", now);
  log.raise(kLost, "", now);
  const auto active = log.active();
  ASSERT_EQ(active.size(), 3u);
  EXPECT_EQ(active[0].alarm, kLost);
  EXPECT_EQ(active[2].alarm.cause, AlarmCause::kWheelInStep);
  for (std::int32_t node = 1; node < 5000; ++node) log.raise({AlarmCause::kSamplesLost, node}, "", now);
  EXPECT_EQ(log.active().size(), AlarmLog::kMostAlarms);
}

}  // namespace
}  // namespace roadbalance
