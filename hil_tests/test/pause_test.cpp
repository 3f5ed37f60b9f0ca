#include <gtest/gtest.h>

#include <csignal>

#include "hil_tests/measurement.hpp"

namespace roadbalance {
namespace {

using test::Program;

class Pause : public test::Measurement {
 protected:
  // Longer than the owner's lease of 0.7 s.
  const double pause_s = test::full_run() ? 5.0 : 1.5;
  // In real time: at any other rate the simulated device waits for its reader, and nothing could be lost.
  const std::string length = "seconds=10000";
  const std::string drive = "rate=1&" + length;
};

TEST_F(Pause, ARecorderThatStandsStillLosesNothing) {
  Program running = recorder();
  Program front = node("front", drive);
  ASSERT_TRUE(more_are_durable(kFront, 50));

  running.signal(SIGSTOP);
  bus.listen(0.3);  // what it had sent before has arrived
  const Heartbeat before = bus.heartbeat(kFront);
  bus.listen(pause_s);
  const Heartbeat during = bus.heartbeat(kFront);
  EXPECT_EQ(during.base, before.base) << "freed while nobody could have recorded it";
  EXPECT_GT(during.next, before.next) << "sampling must not wait for a recorder";
  EXPECT_EQ(during.scans_missing, 0);
  running.signal(SIGCONT);

  ASSERT_TRUE(backlog_is_gone(kFront));
  EXPECT_EQ(bus.heartbeat(kFront).owner, before.owner) << "nobody else had asked for the node";
  end_well(running, {&front});
  expect_complete(1);
  expect_as_simulated("front", length);
}

// The simulated device keeps all that its reader is late for; the node has to take it in one go.
TEST_F(Pause, ANodeThatStandsStillCatchesUpAndLosesNothing) {
  Program running = recorder();
  Program front = node("front", drive);
  ASSERT_TRUE(more_are_durable(kFront, 50));
  front.signal(SIGSTOP);
  bus.listen(0.3);  // what it had sent before has arrived
  const Heartbeat before = bus.heartbeat(kFront);
  bus.listen(pause_s);
  EXPECT_EQ(bus.heartbeat(kFront).next, before.next) << "it was not held";
  front.signal(SIGCONT);
  ASSERT_TRUE(more_are_durable(kFront, 50));
  end_well(running, {&front});
  expect_complete(1);
  expect_as_simulated("front", length);
}

TEST_F(Pause, ABoundedRingDeclaresWhatItCouldNotKeepAndLosesNothingElse) {
  Program running = recorder();
  // A second of ring.
  Program front = node("front", drive, {"--ring-mib", "0.25"});
  ASSERT_TRUE(more_are_durable(kFront, 50));
  running.signal(SIGSTOP);
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).scans_missing > 1000; }));
  running.signal(SIGCONT);
  ASSERT_TRUE(backlog_is_gone(kFront));
  ASSERT_TRUE(more_are_durable(kFront, 100));
  end_well(running, {&front});

  const Verification verification = verify_record(record);
  EXPECT_EQ(verification.verdict, Verdict::kIncomplete) << verdict_text(verification);
  EXPECT_EQ(test::check_record(record), static_cast<int>(Verdict::kIncomplete));
  ASSERT_EQ(verification.epoch.size(), 1u);
  const VerifiedEpoch& epoch = verification.epoch[0];
  EXPECT_EQ(epoch.samples + epoch.samples_missing, epoch.samples_sent);
  ASSERT_FALSE(epoch.gaps.empty());
  for (const auto& gap : epoch.gaps) EXPECT_EQ(gap.cause, GapCause::kRingFull);
}

}  // namespace
}  // namespace roadbalance
