#include "tools/rb/supervisor.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Act = Supervisor::Act;

class SupervisorTest : public ::testing::Test {
 protected:
  // Waits for the next start and returns how long that took.
  milliseconds wait_for_start() {
    const WallTime from = now;
    while (supervisor.due(now) != Act::kStart) now += std::max(milliseconds(1), supervisor.time_left(now));
    supervisor.started(now);
    return std::chrono::duration_cast<milliseconds>(now - from);
  }

  Supervisor supervisor{{.watchdog = seconds(2)}};
  WallTime now{};
};

TEST_F(SupervisorTest, StartsAgainAtOnceAndThenEverMoreSlowlyUpToALimit) {
  EXPECT_EQ(wait_for_start(), milliseconds(0));
  std::vector<milliseconds> waits;
  for (int k = 0; k < 10; ++k) {
    now += milliseconds(50);
    supervisor.ended(4, now);
    waits.push_back(wait_for_start());
  }
  const std::vector<milliseconds> expected{
      milliseconds(0),    milliseconds(100),  milliseconds(200),  milliseconds(400),    milliseconds(800),
      milliseconds(1600), milliseconds(3200), milliseconds(6400), milliseconds(10'000), milliseconds(10'000)};
  EXPECT_EQ(waits, expected);
  EXPECT_EQ(supervisor.restarts(), 10);
}

TEST_F(SupervisorTest, DoesNotStartAgainWhatHasEndedThoughSamplesAreMissing) {
  wait_for_start();
  supervisor.ended(3, now);
  EXPECT_EQ(supervisor.over(), 3);
}

TEST_F(SupervisorTest, TrustsAProgramAgainThatRanWell) {
  wait_for_start();
  for (int k = 0; k < 6; ++k) {
    supervisor.ended(137, now);
    wait_for_start();
  }
  now += seconds(11);
  supervisor.ended(137, now);
  EXPECT_EQ(wait_for_start(), milliseconds(0));
}

TEST_F(SupervisorTest, KillsWhatIsNotFedInTimeAndStartsItAgain) {
  wait_for_start();
  now += seconds(30);
  EXPECT_EQ(supervisor.due(now), Act::kNone) << "a start may take long";
  supervisor.take("READY=1", now);
  for (int k = 0; k < 10; ++k) {
    now += milliseconds(1900);
    EXPECT_EQ(supervisor.due(now), Act::kNone);
    supervisor.take("WATCHDOG=1\n", now);
  }
  now += milliseconds(2000);
  EXPECT_EQ(supervisor.due(now), Act::kKill);
  EXPECT_EQ(supervisor.due(now), Act::kNone) << "once";
  supervisor.ended(137, now);
  EXPECT_EQ(wait_for_start(), milliseconds(0));
}

TEST_F(SupervisorTest, KillsWhatNeverBecomesReady) {
  wait_for_start();
  now += seconds(61);
  EXPECT_EQ(supervisor.due(now), Act::kKill);
}

TEST_F(SupervisorTest, KillsAStartNoSoonerThanItsWatchdogSays) {
  Supervisor patient({.watchdog = seconds(300)});
  patient.started(now);
  now += seconds(299);
  EXPECT_EQ(patient.due(now), Act::kNone);
  EXPECT_LE(patient.time_left(now), seconds(1));
  now += seconds(1);
  EXPECT_EQ(patient.due(now), Act::kKill);
}

TEST_F(SupervisorTest, LetsAProgramBeSilentThatIsNotWatched) {
  Supervisor patient({.watchdog = std::nullopt});
  patient.started(now);
  now += std::chrono::hours(1);
  EXPECT_EQ(patient.due(now), Act::kNone);
}

TEST_F(SupervisorTest, IsOverWhenTheProgramIsOrCannotBeUsedLikeThisOrWasToldToStop) {
  wait_for_start();
  supervisor.ended(0, now);
  EXPECT_EQ(supervisor.over(), 0);

  Supervisor usage({});
  usage.started(now);
  usage.ended(2, now);
  EXPECT_EQ(usage.over(), 2);

  Supervisor stopped({});
  stopped.started(now);
  stopped.stop();
  stopped.ended(143, now);
  EXPECT_EQ(stopped.over(), 143);
  EXPECT_EQ(stopped.due(now + seconds(100)), Act::kNone);
}

TEST_F(SupervisorTest, KeepsWhatTheProgramSaidLast) {
  wait_for_start();
  supervisor.take("WATCHDOG=1\nSTATUS=1 node", now);
  supervisor.take("STATUS=2 nodes", now);
  supervisor.take("MAINPID=1\n\nnonsense", now);
  EXPECT_EQ(supervisor.status(), "2 nodes");
}

}  // namespace
}  // namespace roadbalance
