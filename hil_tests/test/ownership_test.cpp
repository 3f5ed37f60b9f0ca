#include <gtest/gtest.h>

#include <csignal>
#include <set>

#include "common/bus/codec.hpp"
#include "common/record/record_reader.hpp"
#include "hil_tests/measurement.hpp"

namespace roadbalance {
namespace {

using test::Program;

class Ownership : public test::Measurement {
 protected:
  const std::string drive = "rate=5&seconds=10000";

  /// Numbers of the blocks that a node itself sealed.
  static std::set<std::int64_t> recorded(const std::filesystem::path& folder) {
    std::set<std::int64_t> sequences;
    RecordReader reader(folder);
    reader.finish();
    SealedBlock block;
    while (const auto event = reader.next())
      if (accept(event->data, block) == Refusal::kNone && block.header.sequence > 0 &&
          block.kind != BlockKind::kGap)
        sequences.insert(block.header.sequence);
    return sequences;
  }
};

TEST_F(Ownership, ASecondRecorderIsRefusedWhileTheFirstLives) {
  Program first = recorder();
  Program front = node("front", drive);
  ASSERT_TRUE(more_are_durable(kFront, 100));
  const std::int64_t owner = bus.heartbeat(kFront).owner;

  const std::filesystem::path elsewhere = work / "second";
  Program second = recorder(elsewhere);
  ASSERT_TRUE(more_are_durable(kFront, 2000));
  EXPECT_EQ(bus.heartbeat(kFront).owner, owner);
  second.signal(SIGTERM);
  EXPECT_EQ(second.exit_code(test::BusWatch::kPatience_s), 0);
  EXPECT_EQ(bus.heartbeat(kFront).state, NodeState::kStarted) << "an observer has stopped the node";

  ASSERT_TRUE(more_are_durable(kFront, 100));
  end_well(first, {&front});
  expect_complete(1);
}

TEST_F(Ownership, ASecondRecorderTakesOverFromADeadOneAndTogetherTheyAreComplete) {
  Program first = recorder();
  Program front = node("front", drive);
  ASSERT_TRUE(more_are_durable(kFront, 500));
  const std::filesystem::path elsewhere = work / "second";
  Program second = recorder(elsewhere);
  const std::int64_t owner = bus.heartbeat(kFront).owner;
  first.kill();
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).owner != owner; })) << "the lease is over";
  ASSERT_TRUE(more_are_durable(kFront, 500));
  end_well(second, {&front});

  // The node's end counts every sample; each of them is in one of the two, none is lost at the
  // node.
  const Verification before = verify_record(record), after = verify_record(elsewhere);
  ASSERT_EQ(before.epoch.size(), 1u);
  ASSERT_EQ(after.epoch.size(), 1u);
  EXPECT_NE(before.verdict, Verdict::kDamaged) << verdict_text(before);
  EXPECT_NE(after.verdict, Verdict::kDamaged) << verdict_text(after);
  EXPECT_TRUE(after.epoch[0].ended);
  std::set<std::int64_t> sequences = recorded(record);
  sequences.merge(recorded(elsewhere));
  EXPECT_EQ(std::ssize(sequences), after.epoch[0].last_sequence);
}

TEST_F(Ownership, TwoNodesWithOneNumberAreAnAlarmAndRecordedApart) {
  Program running = recorder();
  Program one = node("front", drive);
  ASSERT_TRUE(more_are_durable(kFront, 100));
  Program other = node("front", drive);
  ASSERT_TRUE(bus.wait([&] { return bus.recorder() && bus.recorder()->rivals > 0; })) << "no alarm";
  bus.listen(2.0);
  end_well(running, {&one, &other});
  expect_complete(2);
}

}  // namespace
}  // namespace roadbalance
