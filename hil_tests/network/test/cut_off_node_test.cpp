#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "hil_tests/network/three_hosts.hpp"
#include "hil_tests/test/operating_fixture.hpp"

namespace roadbalance {
namespace {

using test::Program;

/// A recorder that starts and stops on request on host 0, a staying node on each of two others.
class CutOffNode : protected test::ThreeHosts, public Operating {
 protected:
  CutOffNode() : Operating(test::kNetworkUrl) {}
  void SetUp() override {
    if (!hosts) GTEST_SKIP() << *test::Hosts::refusal();
  }
  Program staying_on(std::size_t host, const std::string& name) {
    return hosts->on(host, [&] { return staying(name); });
  }
  /// With the node in front cut off: the recorder waits ten seconds for it, and reports the truth.
  void stop_without_front(const std::string& name) {
    hosts->pull(1);
    bus.listen(0.3);  // some samples are taken without being heard
    const Answer stopped = ask(Operation::kStop);
    ASSERT_EQ(stopped.state, AnswerState::kDone) << stopped.text;
    EXPECT_NE(stopped.text.find("node 1 has not told all"), std::string::npos) << stopped.text;
    const auto receipts = asking.receipts(kPatience);
    ASSERT_EQ(receipts.size(), 2u);
    EXPECT_EQ(receipts.at(0).open_epochs, 1);
    EXPECT_EQ(receipts.at(1).open_epochs, 0);
    EXPECT_FALSE(are_whole(receipts));
    EXPECT_EQ(verify_record(recordings / name).verdict, Verdict::kIncomplete);
  }
  bool comes_to_be_whole(const std::string& name) {
    return test::wait_until(
        [&] {
          bus.listen(0.2);
          return verify_record(recordings / name).verdict == Verdict::kComplete;
        },
        60);
  }
  bool receipts_come_to_be_whole() {
    return test::wait_until(
        [&] {
          bus.listen(0.2);
          (void)asking.ask({.operation = Operation::kMark}, std::chrono::milliseconds(500));  // hears of them
          return are_whole(asking.receipts(std::chrono::milliseconds(100)));
        },
        60);
  }
};

TEST_F(CutOffNode, TheRemainderOfARecordingIsFetchedIntoItWhenTheNodeIsBack) {
  Program recorder = operated_recorder(), front = staying_on(1, "front"), rear = staying_on(2, "rear");
  start("first");
  const std::int64_t epoch = bus.heartbeat(kFront).epoch;
  ASSERT_TRUE(more_are_durable(kFront, 100));
  stop_without_front("first");
  bus.listen(3);
  hosts->plug(1);
  EXPECT_TRUE(comes_to_be_whole("first"));
  EXPECT_TRUE(receipts_come_to_be_whole());
  expect_whole("first");
  // And the node begins a new epoch, with nothing of the one before.
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).epoch != epoch; }));
  start("second");
  ASSERT_TRUE(more_are_durable(kFront, 50));
  stop();
  expect_whole("second");
}

TEST_F(CutOffNode, TheNextRecordingTakesNothingOfItAndTheNodeJoinsWhenItIsBack) {
  Program recorder = operated_recorder(), front = staying_on(1, "front"), rear = staying_on(2, "rear");
  start("first");
  const std::int64_t epoch = bus.heartbeat(kFront).epoch;
  ASSERT_TRUE(more_are_durable(kFront, 100));
  stop_without_front("first");
  ASSERT_EQ(ask(Operation::kStart, "second").state, AnswerState::kDone);
  ASSERT_TRUE(more_are_durable(kRear, 100));
  hosts->plug(1);
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).epoch != epoch; }));
  ASSERT_TRUE(more_are_durable(kFront, 100));
  ASSERT_EQ(ask(Operation::kStop).state, AnswerState::kDone);
  expect_whole("first");
  const Verification second = verify_record(recordings / "second");  // the front node came into it late
  ASSERT_EQ(second.absent.size(), 1u);
  EXPECT_EQ(second.absent.front().text.find("node 1 (front) came "), 0u) << second.absent.front().text;
  EXPECT_TRUE(std::ranges::all_of(second.epoch, &VerifiedEpoch::is_complete));
  EXPECT_EQ(test::check_record(recordings / "second"), 3) << "the independent checker";
}

TEST_F(CutOffNode, ARecorderKilledWhileItFetchesFetchesAllTheSame) {
  const int turns = test::full_run() ? 10 : 2;
  Program recorder = operated_recorder(), front = staying_on(1, "front"), rear = staying_on(2, "rear");
  for (int turn = 0; turn < turns; ++turn) {
    const std::string name = "turn" + std::to_string(turn);
    start(name);
    ASSERT_TRUE(more_are_durable(kFront, 100));
    stop_without_front(name);
    recorder.kill();
    recorder = operated_recorder();
    hosts->plug(1);
    for (const double seconds : {0.3, 0.8, 1.3}) {
      bus.listen(seconds + 0.05 * turn);
      recorder.kill();
      recorder = operated_recorder();
    }
    EXPECT_TRUE(comes_to_be_whole(name));
    expect_whole(name);
    const std::int64_t epoch = bus.heartbeat(kFront).epoch;
    ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).state == NodeState::kPreview; })) << epoch;
  }
}

TEST_F(CutOffNode, ANodeStartedAnewHasLostItsRemainderAndTheRecordDeclaresIt) {
  Program recorder = operated_recorder(), rear = staying_on(2, "rear");
  {
    Program front = staying_on(1, "front");
    start("first");
    ASSERT_TRUE(more_are_durable(kFront, 100));
    stop_without_front("first");
    front.kill();
  }
  hosts->plug(1);
  Program front = staying_on(1, "front");
  const auto declares_it = [&] {
    bus.listen(0.2);
    const Verification proof = verify_record(recordings / "first");
    return std::ranges::any_of(proof.epoch, [](const VerifiedEpoch& epoch) {
      return !epoch.gaps.empty() && epoch.gaps.back().cause == GapCause::kNodeCrash;
    });
  };
  EXPECT_TRUE(test::wait_until(declares_it, 60));
  EXPECT_EQ(verify_record(recordings / "first").verdict, Verdict::kIncomplete);
  start("second");
  ASSERT_TRUE(more_are_durable(kFront, 50));
  stop();
  expect_whole("second");
}

}  // namespace
}  // namespace roadbalance
