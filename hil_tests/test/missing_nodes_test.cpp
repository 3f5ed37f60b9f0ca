// A node that does not measure from the start of a recording to its stop: nobody is told that all is there.
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <thread>

#include "common/bus/codec.hpp"
#include "common/bus/control_messages.hpp"
#include "hil_tests/test/operating_fixture.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "host/recording/subset/subset_recording.hpp"

namespace roadbalance {
namespace {

using test::Program;

class MissingNodes : public test::Operating {
 protected:
  bool is_absent(std::int32_t node, AbsenceCause cause) {
    return bus.wait([&] {
      return bus.recorder() && std::ranges::find(bus.recorder()->absent, AbsentNode{node, cause}) !=
                                   bus.recorder()->absent.end();
    });
  }
  /// Starts with both nodes, of which both measure.
  void begin(const std::string& name) {
    start(name);
    ASSERT_TRUE(more_are_durable(kFront, 20));
    ASSERT_TRUE(more_are_durable(kRear, 20));
  }
  /// A part from within an absence lacks that node, unless it was not chosen.
  void expect_parts_tell(const std::string& name) {
    SubsetRequest part{.folder = recordings / name, .output = work.path() / "part"};
    part.time.to_s = 1.0;
    const Verification both = subset_recording(part).verification;
    EXPECT_EQ(both.verdict, Verdict::kIncomplete);
    ASSERT_EQ(both.absent.size(), 1u);
    EXPECT_EQ(both.absent.front().node, kRear);
    part.output = work.path() / "front";
    part.choice.nodes = {"front"};
    EXPECT_EQ(subset_recording(part).verification.verdict, Verdict::kComplete);
  }
  /// Stops, and every judge says what `words` say of the rear node.
  void expect_told(const std::string& name, const std::string& words) {
    const Answer answer = ask(Operation::kStop);
    ASSERT_EQ(answer.state, AnswerState::kDone) << answer.text;
    EXPECT_NE(answer.text.find("node 2 " + words), std::string::npos) << answer.text;
    const auto receipts = asking.receipts(kPatience);
    ASSERT_EQ(receipts.size(), 2u);
    EXPECT_EQ(receipts.at(0).missing(), "");
    EXPECT_EQ(receipts.at(1).missing().find(words), 0u) << receipts.at(1).missing();
    EXPECT_NE(receipts.at(1).stopped_by.find("rb of "), std::string::npos) << receipts.at(1).stopped_by;
    EXPECT_FALSE(are_whole(receipts));
    const Verification result = verify_record(recordings / name);
    EXPECT_EQ(result.verdict, Verdict::kIncomplete);
    ASSERT_EQ(result.absent.size(), 1u);
    EXPECT_EQ(result.absent.front().text.find("node 2 (rear) " + words), 0u) << result.absent.front().text;
    EXPECT_EQ(test::check_record(recordings / name), 3) << "the independent checker";
  }
};

TEST_F(MissingNodes, OfANodeWhoseServiceEndsIt) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  for (const int signal : {SIGTERM, SIGHUP}) {
    const std::string name = "signal " + std::to_string(signal);
    begin(name);
    rear.signal(signal);
    EXPECT_TRUE(is_absent(kRear, AbsenceCause::kProgramEnded));
    expect_told(name, "ended ");
    EXPECT_NE(identify_record(recordings / name).refusal.find("node 2 (rear) ended "), std::string::npos);
    rear = staying("rear");
  }
}

// Whether the recorder hears of its end before the stop or behind it.
TEST_F(MissingNodes, OfANodeThatEndsAtTheStop) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  begin("drive");
  rear.signal(SIGTERM);
  expect_told("drive", "ended ");
}

// Without requests, and before a node that is silent is missed.
TEST_F(MissingNodes, OfANodeThatNeverComesToAShortRecording) {
  const auto said = work.path() / "recorder.log";
  Program recorder("rb-recorder",
                   {"--url", url, "--record", record.string(), "--vehicle", vehicles / "car.toml"}, said);
  Program front = node("front", "rate=1&seconds=10000");
  ASSERT_TRUE(more_are_durable(kFront, 1));
  recorder.signal(SIGTERM);
  EXPECT_EQ(recorder.exit_code(60), 3);
  std::ifstream log(said);
  const std::string all{std::istreambuf_iterator<char>(log), {}};
  EXPECT_NE(all.find("rb-recorder: node 2 (rear) never came"), std::string::npos) << all;
  EXPECT_EQ(verify_record(record).verdict, Verdict::kIncomplete);
}

TEST_F(MissingNodes, OfANodeThatIsKilledNamesTheInstantFromWhichItIsNotHeard) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  begin("drive");
  rear.kill();
  EXPECT_TRUE(is_absent(kRear, AbsenceCause::kSilent));
  expect_told("drive", "was not heard after ");
}

TEST_F(MissingNodes, OfANodeThatSomebodyElseStops) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  begin("drive");
  Bus stranger(url);
  const Heartbeat beat = bus.heartbeat(kRear);
  ASSERT_TRUE(stranger.publish(command_channel(kRear), encode(Command{.node = kRear,
                                                                      .request = 77,
                                                                      .incarnation = beat.owner,
                                                                      .verb = Verb::kStop,
                                                                      .epoch = beat.epoch})));
  // It stays, and begins a new epoch, which the recording takes.
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kRear).epoch != beat.epoch; }));
  ASSERT_TRUE(more_are_durable(kRear, 20));
  expect_told("drive", "was away for ");
}

TEST_F(MissingNodes, OfANodeThatNeverComes) {
  Program recorder = operated_recorder(), front = staying("front");
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).epoch != 0; }));
  Answer answer;
  ASSERT_TRUE(test::wait_until(
      [&] { return (answer = ask(Operation::kStart, "half")).reason != RefusalReason::kNoNode; }, 60));
  ASSERT_EQ(answer.state, AnswerState::kDone) << answer.text;
  EXPECT_EQ(answer.value[0], 1.0);
  EXPECT_NE(answer.text.find("PARTIAL: node 2 (rear) is not on the bus"), std::string::npos) << answer.text;
  EXPECT_TRUE(is_absent(kRear, AbsenceCause::kNeverCame));
  expect_told("half", "never came");
  EXPECT_NE(identify_record(recordings / "half").refusal.find("node 2 (rear) has no sample"),
            std::string::npos);
}

TEST_F(MissingNodes, OfANodeThatComesLateAndOfOneThatIsStartedAgain) {
  Program recorder = operated_recorder(), front = staying("front");
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).epoch != 0; }));
  ASSERT_TRUE(
      test::wait_until([&] { return ask(Operation::kStart, "late").reason != RefusalReason::kNoNode; }, 60));
  ASSERT_TRUE(is_absent(kRear, AbsenceCause::kNeverCame));
  Program rear = staying("rear");
  ASSERT_TRUE(more_are_durable(kRear, 20));
  expect_told("late", "came ");
  expect_parts_tell("late");
  begin("again");
  const std::int64_t before = bus.heartbeat(kRear).epoch;
  rear.signal(SIGTERM);
  ASSERT_EQ(rear.exit_code(30), 0);
  rear = staying("rear");
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kRear).epoch != before; }));
  ASSERT_TRUE(more_are_durable(kRear, 20));
  expect_told("again", "was away for ");
}

TEST_F(MissingNodes, OfNobodyWhereTheStartNamedWhoIsThere) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  begin("both");
  ASSERT_EQ(ask(Operation::kStop).state, AnswerState::kDone);
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).state == NodeState::kPreview; }));
  const Answer unknown = ask(Operation::kStart, "front only", {.nodes = "middle"});
  EXPECT_EQ(unknown.reason, RefusalReason::kBadArgument);
  EXPECT_NE(unknown.text.find("middle: there is none; allowed: front, rear"), std::string::npos)
      << unknown.text;
  const Answer answer = ask(Operation::kStart, "front only", {.nodes = "front"});
  ASSERT_EQ(answer.state, AnswerState::kDone) << answer.text;
  EXPECT_EQ(answer.value[0], 0.0);
  ASSERT_TRUE(more_are_durable(kFront, 20));
  ASSERT_EQ(ask(Operation::kStop).state, AnswerState::kDone);
  EXPECT_TRUE(are_whole(asking.receipts(kPatience)));
  expect_complete(recordings / "front only", 1);
}

TEST_F(MissingNodes, OfANodeThatWasOnlyNotHeardIsOver) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  begin("drive");
  rear.signal(SIGSTOP);  // not heard, and nothing of it is lost: its samples wait
  ASSERT_TRUE(is_absent(kRear, AbsenceCause::kSilent));
  rear.signal(SIGCONT);
  ASSERT_TRUE(bus.wait([&] { return bus.recorder() && bus.recorder()->absent.empty(); }));
  ASSERT_TRUE(more_are_durable(kRear, 20));
  stop();
  expect_whole("drive");
}

}  // namespace
}  // namespace roadbalance
