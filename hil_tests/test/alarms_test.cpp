#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>

#include "common/bus/bus.hpp"
#include "common/bus/channel_faults.hpp"
#include "hil_tests/measurement.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {
namespace {

using test::Program;

class Alarms : public test::Measurement {
 protected:
  const std::string drive = "rate=5&seconds=10000";

  /// Alarms of the finished record.
  std::vector<RecordedAlarm> of(AlarmCause cause) const {
    std::vector<RecordedAlarm> found = verify_record(record).alarms.all();
    std::erase_if(found, [&](const RecordedAlarm& one) { return one.alarm.cause != cause; });
    return found;
  }
};

TEST_F(Alarms, OfANodeThatFallsSilentAreInTheRecordWithBeginAndEnd) {
  Program running = recorder();
  Program front = node("front", drive);
  Program rear = node("rear", drive);
  ASSERT_TRUE(more_are_durable(kFront, 100));
  ASSERT_TRUE(more_are_durable(kRear, 100));
  rear.signal(SIGSTOP);
  bus.listen(5.0);
  rear.signal(SIGCONT);
  ASSERT_TRUE(more_are_durable(kRear, 100));
  end_well(running, {&front, &rear});
  expect_complete(2);
  const auto silent = of(AlarmCause::kNodeSilent);
  ASSERT_EQ(silent.size(), 1u);
  EXPECT_EQ(silent[0].alarm.node, kRear);
  ASSERT_TRUE(silent[0].ended_us);
  EXPECT_GT(*silent[0].ended_us, silent[0].began_us);
  EXPECT_EQ(sentence(silent[0]).find("ALARM node 2: silent"), 0u) << sentence(silent[0]);
}

TEST_F(Alarms, OfTheAnalyserAreInTheRecordOnceHoweverOftenTheyAreSaid) {
  Program running = recorder();
  Program front = node("front", drive);
  ASSERT_TRUE(more_are_durable(kFront, 100));
  Bus analyser(url);
  Level level{.node = kFront};
  set_dead(level, 2);
  level.overload = 1U << 5;
  for (int k = 0; k < 200; ++k) {
    level.time_ns = k;
    level.overload = level.overload != 0 ? 0 : 1U << 5;  // it flaps
    ASSERT_TRUE(analyser.publish(kLevelChannel, encode(level)));
    bus.listen(0.01);
  }
  level.node = 9;  // of no node that is recorded
  ASSERT_TRUE(analyser.publish(kLevelChannel, encode(level)));
  ASSERT_TRUE(more_are_durable(kFront, 100));
  end_well(running, {&front});
  expect_complete(1);
  const auto overload = of(AlarmCause::kOverload), dead = of(AlarmCause::kDeadChannel);
  ASSERT_EQ(overload.size(), 1u);
  EXPECT_EQ(place_of(overload[0].alarm), "node 1 channel 6");
  ASSERT_EQ(dead.size(), 1u);
  EXPECT_EQ(place_of(dead[0].alarm), "node 1 channel 3");
  EXPECT_TRUE(overload[0].ended_us && dead[0].ended_us) << "at the latest with the recording";
}

}  // namespace
}  // namespace roadbalance
