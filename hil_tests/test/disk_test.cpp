#include <gtest/gtest.h>

#include "hil_tests/measurement.hpp"
#include "hil_tests/private_mounts.hpp"

namespace roadbalance {
namespace {

using test::Program;

/// The recorder's disk fails; the nodes hold what it cannot take.
class Disk : public test::Measurement {
 protected:
  static void SetUpTestSuite() { refusal() = test::enter_private_mounts(); }
  void SetUp() override {
    if (refusal()) GTEST_SKIP() << *refusal();
  }
  static std::optional<std::string>& refusal() {
    static std::optional<std::string> why;
    return why;
  }

  static constexpr std::uint64_t kMiB = 1 << 20;
  const std::string length = "seconds=10000";
  const std::string drive = "rate=5&" + length;  // the ring holds 20 s of it

  bool state_is(RecorderState state) {
    return bus.wait([&] { return bus.recorder() && bus.recorder()->state == state; });
  }
  /// The node samples on, and nothing is freed.
  void expect_that_the_node_holds_everything() {
    // Blocks that credit had let out before are still recorded.
    ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).ring_used > 1000; }));
    const Heartbeat before = bus.heartbeat(kFront);
    bus.listen(test::full_run() ? 5.0 : 1.0);
    const Heartbeat later = bus.heartbeat(kFront);
    EXPECT_EQ(later.base, before.base);
    EXPECT_GT(later.next, before.next);
    EXPECT_EQ(later.scans_missing, 0);
  }
};

TEST_F(Disk, AFullDiskIsAStateAndLosesNothing) {
  test::MemoryDisk disk(record, 256 * kMiB);
  Program running = recorder();
  Program front = node("front", drive);
  ASSERT_TRUE(more_are_durable(kFront, 500));
  for (int k = 0; k < (test::full_run() ? 5 : 1); ++k) {
    disk.fill_leaving(k % 2 == 0 ? 4 * kMiB : 0);
    ASSERT_TRUE(state_is(RecorderState::kDiskFull));
    expect_that_the_node_holds_everything();
    disk.free_again();
    ASSERT_TRUE(state_is(RecorderState::kRecording));
    ASSERT_TRUE(backlog_is_gone(kFront));
    ASSERT_TRUE(more_are_durable(kFront, 500));
  }
  end_well(running, {&front});
  expect_complete(1);
  expect_as_simulated("front", length);
}

TEST_F(Disk, ADiskThatTurnsReadOnlyIsAStateAndLosesNothing) {
  if (const auto why = test::FailingDisk::refusal()) GTEST_SKIP() << *why;
  test::FailingDisk disk(work / "image", record, 256);
  Program running = recorder();
  Program front = node("front", drive);
  ASSERT_TRUE(more_are_durable(kFront, 500));

  disk.turn_read_only();
  ASSERT_TRUE(state_is(RecorderState::kDiskFailing));
  expect_that_the_node_holds_everything();
  EXPECT_FALSE(running.exit_code(0)) << "it ended";
  // It tries again each second, and the folder beneath would take it.
  disk.unmount();
  bus.listen(2.5);
  EXPECT_TRUE(std::filesystem::is_empty(record));
  disk.repair();

  ASSERT_TRUE(state_is(RecorderState::kRecording));
  ASSERT_TRUE(backlog_is_gone(kFront));
  ASSERT_TRUE(more_are_durable(kFront, 500));
  end_well(running, {&front});
  expect_complete(1);
  expect_as_simulated("front", length);
}

TEST_F(Disk, AFallbackFolderTakesOverAndTogetherTheyAreComplete) {
  if (const auto why = test::FailingDisk::refusal()) GTEST_SKIP() << *why;
  test::FailingDisk disk(work / "image", record, 256);
  const std::filesystem::path fallback = work / "fallback";
  Program running = recorder({"--fallback", fallback});
  Program front = node("front", drive);
  ASSERT_TRUE(more_are_durable(kFront, 500));
  disk.turn_read_only();
  ASSERT_TRUE(bus.wait([&] { return bus.recorder() && bus.recorder()->fallback; }));
  ASSERT_TRUE(backlog_is_gone(kFront));
  ASSERT_TRUE(more_are_durable(kFront, 500));
  end_well(running, {&front});

  const Verification first = verify_record(record), rest = verify_record(fallback);
  ASSERT_EQ(first.epoch.size(), 1u);
  ASSERT_EQ(rest.epoch.size(), 1u);
  EXPECT_FALSE(first.epoch[0].ended);
  EXPECT_TRUE(rest.epoch[0].ended);
  // Blocks that were written and not synced when the disk failed are in both.
  EXPECT_LT(first.epoch[0].samples, rest.epoch[0].samples_sent);
  EXPECT_LT(rest.epoch[0].samples, rest.epoch[0].samples_sent);
  EXPECT_GE(first.epoch[0].samples + rest.epoch[0].samples, rest.epoch[0].samples_sent);
  EXPECT_EQ(test::check_record(record), static_cast<int>(Verdict::kIncomplete)) << "it has no end";

  const std::filesystem::path whole = work / "whole";
  ASSERT_EQ(test::run("rb", {"recover", record, "--spool", fallback, "-o", whole}, 60), 0);
  expect_complete(whole, 1);
  expect_as_simulated(whole, "front", length);
}

}  // namespace
}  // namespace roadbalance
