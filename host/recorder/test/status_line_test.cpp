#include "host/recorder/status_line.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

TEST(StatusLine, SaysWhereHowMuchAndHowLongStill) {
  RecorderStatus status;
  status.segment = 3;
  status.bytes_recorded = 1'234'000'000;
  status.bytes_free = 34'000'000'000;
  EXPECT_EQ(status_line(status), "records to segment 3: 1.2 GB so far, 34 GB free");
  status.seconds_left = 5.1 * 3600;
  EXPECT_EQ(status_line(status), "records to segment 3: 1.2 GB so far, 34 GB free, 5.1 h left");
  status.state = RecorderState::kStopping;
  status.seconds_left = 90 * 60;
  EXPECT_EQ(status_line(status), "stops recording to segment 3: 1.2 GB so far, 34 GB free, 90 min left");
  EXPECT_TRUE(alarms(status).empty());
}

TEST(StatusLine, PutsTheMostUrgentAlarmFirst) {
  RecorderStatus status;
  status.state = RecorderState::kDiskFailing;
  status.disk_failures = 7;
  status.waiting_blocks = 120;
  status.on_battery = true;
  status.fallback = true;
  status.rivals = 2;
  status.seconds_left = 600;
  status.sync_s = 3.2;
  status.unsent = 1;
  const auto lines = alarms(status);
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_EQ(lines[0].text, "THE DISK FAILS (7 times): 120 blocks wait, the nodes keep what they measure");
  // The fallback folder is a notice, and comes behind what is a warning.
  EXPECT_EQ(lines[3].text, "the disk is full in 10 min");
  EXPECT_EQ(lines[6].cause, AlarmCause::kFallback);
}

TEST(StatusLine, SaysHowLongASyncTookWhateverARecorderClaims) {
  RecorderStatus status;
  status.sync_s = 3.2;
  ASSERT_EQ(alarms(status).size(), 1u);
  EXPECT_EQ(alarms(status)[0].text, "the disk is slow: its last sync took 3 s");
  status.sync_s = 1e10;
  EXPECT_EQ(alarms(status)[0].text, "the disk is slow: its last sync took 10000000000 s");
}

TEST(StatusLine, SaysThatTheSupplyCannotBeRead) {
  RecorderStatus status;
  status.power_unknown = true;
  ASSERT_EQ(alarms(status).size(), 1u);
  EXPECT_EQ(alarms(status)[0].text, "whether the supply is there cannot be read");
}

TEST(StatusLine, SaysWhatIsWrongWithARecordingThatGoesOn) {
  RecorderStatus status;
  status.fault = "node 2 measures by another vehicle file than car.toml: choose that file again";
  ASSERT_EQ(alarms(status).size(), 1u);
  EXPECT_EQ(alarms(status)[0].text, status.fault);
}

TEST(StatusLine, SaysOnceThatTheDiskIsFull) {
  RecorderStatus status;
  status.state = RecorderState::kDiskFull;
  status.seconds_left = 0;
  EXPECT_EQ(alarms(status).size(), 1u);
}

}  // namespace
}  // namespace roadbalance
