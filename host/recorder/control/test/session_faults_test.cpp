#include <gtest/gtest.h>

#include <algorithm>

#include "host/recorder/control/test/session_fixture.hpp"

namespace roadbalance {
namespace {

using test::ask, test::kNow, test::SessionControllerTest;

TEST_F(SessionControllerTest, AMarkIsDoneOnlyIfItIsOnTheDisk) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.take(ask(Operation::kMark, 2), kNow, {2});
  controller.take(ask(Operation::kMark, 3), kNow, {2});
  controller.runs(true, 1, kNow);
  controller.take(ask(Operation::kStop, 4), kNow, {2});
  (void)controller.answers();
  controller.ended({}, {}, kNow, kNow / 1000 + 500);
  controller.take(ask(Operation::kMark, 2), kNow, {2});
  EXPECT_EQ(last(controller).state, AnswerState::kDone);
  controller.take(ask(Operation::kMark, 3), kNow, {2});
  const Answer lost = last(controller);
  EXPECT_EQ(lost.state, AnswerState::kRefused);
  EXPECT_EQ(lost.reason, RefusalReason::kDisk);
}

TEST_F(SessionControllerTest, RefusesWhatCannotBeAndSaysWhy) {
  taken = {"drive"};
  SessionController controller = this->controller();
  const auto reason = [&](const Request& request, int nodes) {
    controller.take(request, kNow, {nodes});
    const Answer answer = last(controller);
    EXPECT_EQ(answer.state, AnswerState::kRefused);
    EXPECT_FALSE(answer.text.empty());
    return answer.reason;
  };
  EXPECT_EQ(reason(ask(Operation::kStart, 1, "drive"), 2), RefusalReason::kNameTaken);
  EXPECT_EQ(reason(ask(Operation::kStart, 2, "../drive"), 2), RefusalReason::kBadArgument);
  EXPECT_EQ(reason(ask(Operation::kStart, 3, ".."), 2), RefusalReason::kBadArgument);
  EXPECT_EQ(reason(ask(Operation::kStart, 4, kSessionStateFile), 2), RefusalReason::kBadArgument);
  EXPECT_EQ(reason(ask(Operation::kStart, 5, std::string(65, 'x')), 2), RefusalReason::kBadArgument);
  EXPECT_EQ(reason(ask(Operation::kStart, 6, "new"), 0), RefusalReason::kNoNode);
  EXPECT_EQ(reason(ask(Operation::kStop, 7), 2), RefusalReason::kNotRecording);
  EXPECT_EQ(reason(ask(Operation::kMark, 8), 2), RefusalReason::kNotRecording);
  EXPECT_EQ(reason(ask(static_cast<Operation>(99), 9), 2), RefusalReason::kUnknownOperation);
  disk_fails = true;
  EXPECT_EQ(reason(ask(Operation::kStart, 10, "new"), 2), RefusalReason::kDisk);
  EXPECT_TRUE(done.empty());
}

// The nodes get the new text only when the session state has it: a recorder that is killed then knows what to
// undo.
TEST_F(SessionControllerTest, ASetUpIsInTheBookBeforeItIsDoneAndAnsweredOnce) {
  SessionController controller = this->controller();
  disk_fails = true;
  controller.take(ask(Operation::kRange, 1), kNow, {1});
  EXPECT_EQ(last(controller).reason, RefusalReason::kDisk);
  EXPECT_EQ(done, std::vector<std::string>{"forget"});
  disk_fails = false;
  SessionController second = this->controller();
  second.take(ask(Operation::kRange, 1), kNow, {1});
  ASSERT_TRUE(state.set_up);
  EXPECT_EQ(state.set_up->vehicle_crc32c, 5u);
  SessionController third = this->controller();  // it was killed
  third.take(ask(Operation::kRange, 1), kNow, {1});
  EXPECT_EQ(last(third).state, AnswerState::kUnderWay);
  third.was_set_up({.asker = 7,
                    .request = 1,
                    .operation = Operation::kRange,
                    .state = AnswerState::kRefused,
                    .reason = RefusalReason::kNotSupported,
                    .text = "undone"});
  SessionController fourth = this->controller();
  fourth.take(ask(Operation::kRange, 1), kNow, {1});
  const Answer answer = last(fourth);
  EXPECT_EQ(answer.state, AnswerState::kRefused);
  EXPECT_EQ(answer.reason, RefusalReason::kNotSupported);
  EXPECT_EQ(answer.text, "undone");
}

// Killed at each step and begun anew, with the requester repeating what was not answered.
TEST_F(SessionControllerTest, ARecorderThatIsKilledGoesOnWithWhatWasAsked) {
  controller().take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  {
    SessionController second = controller();
    EXPECT_EQ(done.back(), "begin drive");
    second.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
    EXPECT_EQ(last(second).state, AnswerState::kUnderWay);
    second.runs(true, 0, kNow);
    EXPECT_EQ(last(second).state, AnswerState::kDone);
    second.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
  }
  done.clear();
  {
    SessionController third = controller();
    const std::vector<std::string> expected{"begin drive", "mark 1 bridge"};
    EXPECT_EQ(done, expected) << "it may not be on the disk";
    third.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
    EXPECT_EQ(last(third).value[0], 1);
    third.runs(true, 1, kNow);
    EXPECT_EQ(last(third).state, AnswerState::kDone);
    third.take(ask(Operation::kStop, 3), kNow, {2});
  }
  done.clear();
  {
    SessionController fourth = controller();
    const std::vector<std::string> expected{"begin drive", "stop"};
    EXPECT_EQ(done, expected);
    fourth.take(ask(Operation::kStop, 3), kNow, {2});
    fourth.ended({Receipt{.name = "drive"}}, {}, kNow, kNow / 1000 + 500);
    EXPECT_EQ(last(fourth).state, AnswerState::kDone);
  }
  SessionController fifth = controller();
  EXPECT_FALSE(fifth.active());
  fifth.take(ask(Operation::kStop, 3), kNow, {2});
  EXPECT_EQ(last(fifth).state, AnswerState::kDone);
  fifth.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  EXPECT_EQ(last(fifth).state, AnswerState::kDone) << "a late repetition starts nothing";
  EXPECT_FALSE(fifth.active());
}

TEST_F(SessionControllerTest, ARecordingThatFailsIsAFaultAndGoesOn) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.runs(true, 0, kNow);
  controller.failed("the disk is gone", true, kNow);
  EXPECT_EQ(controller.fault(), "the disk is gone");
  ASSERT_TRUE(controller.active());
  controller.again();
  EXPECT_EQ(std::ranges::count(done, "begin drive"), 2);
  controller.runs(true, 0, kNow);
  EXPECT_EQ(controller.fault(), "");
}

TEST_F(SessionControllerTest, AStartWhoseFolderCannotBeOpenedIsRefused) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.failed("open drive: read-only", false, kNow);
  const Answer answer = last(controller);
  EXPECT_EQ(answer.state, AnswerState::kRefused);
  EXPECT_EQ(answer.reason, RefusalReason::kDisk);
  EXPECT_FALSE(controller.active());
  EXPECT_FALSE(state.active);
}

// A disk so slow that the recording is stopped before it turns out that it cannot be begun.
TEST_F(SessionControllerTest, AStopAndMarksOfARecordingThatIsGivenUpAreRefusedToo) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
  controller.take(ask(Operation::kStop, 3), kNow, {2});
  (void)controller.answers();
  controller.failed("open drive: read-only", false, kNow);
  std::set<std::int64_t> refused;
  for (const Answer& answer : controller.answers()) {
    EXPECT_EQ(answer.state, AnswerState::kRefused);
    EXPECT_EQ(answer.reason, RefusalReason::kDisk);
    EXPECT_NE(answer.text.find("read-only"), std::string::npos) << answer.text;
    refused.insert(answer.request);
  }
  EXPECT_EQ(refused, (std::set<std::int64_t>{1, 2, 3}));
  controller.take(ask(Operation::kStop, 3), kNow, {2});
  EXPECT_EQ(last(controller).state, AnswerState::kRefused) << "whoever asks again hears it, too";
}

// Whoever asked repeats it until it is answered: that does not make this recorder the one that began it.
TEST_F(SessionControllerTest, AStartThatWasTakenOverIsNeverRefusedForItMayHoldSamples) {
  controller().take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  SessionController second = controller();
  second.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  second.failed("open drive: read-only", false, kNow);
  EXPECT_NE(last(second).state, AnswerState::kRefused);
  EXPECT_TRUE(second.active());
  EXPECT_TRUE(state.active);
}

// The disk fails over a stop for longer than the session waits, and still when it is begun again.
TEST_F(SessionControllerTest, ARecordingThatHasRunIsNeverGivenUpHoweverOftenItFails) {
  for (const bool has_samples : {true, false}) {
    state = {};
    SessionController controller = this->controller();
    controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
    controller.runs(has_samples, 0, kNow);
    controller.take(ask(Operation::kStop, 2), kNow, {2});
    controller.failed("sync: input/output error", true, kNow);
    (void)controller.answers();
    for (int k = 0; k < 3; ++k) {
      controller.again();
      controller.failed("open drive: read-only", false, kNow);
      ASSERT_TRUE(controller.active());
      ASSERT_TRUE(state.active);
      EXPECT_EQ(controller.fault(), "open drive: read-only");
      EXPECT_TRUE(controller.answers().empty());
    }
    controller.again();
    EXPECT_EQ(done.back(), "stop");
    controller.ended({Receipt{.name = "drive"}}, {{"drive", 2, 77}}, kNow, kNow / 1000 + 500);
    for (const Answer& answer : controller.answers())
      EXPECT_EQ(answer.state, AnswerState::kDone) << answer.text;
    EXPECT_EQ(controller.pending(), (std::vector<PendingEpoch>{{"drive", 2, 77}}));
    controller.take(ask(Operation::kStart, 3, "next"), kNow, {2});
    controller.failed("open next: read-only", false, kNow);
    EXPECT_FALSE(controller.active()) << "that one is empty";
  }
}

// Whoever repeats a mark that is on the disk learns so; that the disk fails now remains true.
TEST_F(SessionControllerTest, AMarkThatIsRepeatedEndsNoFault) {
  {
    SessionController first = this->controller();
    first.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
    first.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
    first.runs(true, 1, kNow);
  }
  SessionController controller = this->controller();
  controller.failed("open drive: read-only", false, kNow);
  controller.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
  EXPECT_EQ(last(controller).state, AnswerState::kDone);
  EXPECT_EQ(controller.fault(), "open drive: read-only");
}

// Otherwise a recorder that is killed later finds a recording in the session state whose start was refused.
TEST_F(SessionControllerTest, ABookThatCouldNotBeWrittenIsWrittenAgain) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  disk_fails = true;
  controller.failed("open drive: read-only", false, kNow);
  EXPECT_EQ(last(controller).state, AnswerState::kRefused);
  controller.write_again();
  EXPECT_TRUE(state.active) << "the disk still fails";
  disk_fails = false;
  controller.write_again();
  EXPECT_FALSE(state.active);
}

TEST_F(SessionControllerTest, RemembersTheIncarnationsOfRecordingsThatAreOver) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.ended({Receipt{.incarnation = kNow / 1000 + 500, .name = "drive"}}, {}, kNow, kNow / 1000 + 500);
  EXPECT_EQ(controller.past(), (std::vector<PastRecording>{{"drive", kNow / 1000, kNow / 1000 + 500}}));
  controller.owe({{"drive", 2, 77}});
  EXPECT_EQ(this->controller().pending(), (std::vector<PendingEpoch>{{"drive", 2, 77}}))
      << "in the session state";
}

// Owed again at each turn, for what is not in the session state is unknown: nothing may be pushed out or
// written for it.
TEST_F(SessionControllerTest, AFullBookOwesNothingMoreUntilThereIsRoom) {
  SessionController controller = this->controller();
  std::vector<PendingEpoch> pending;
  for (std::int64_t epoch = 1; epoch < static_cast<std::int64_t>(kMostPendingEpochs); ++epoch)
    pending.push_back({"drive", 1, epoch});
  controller.owe(pending);
  controller.owe({{"drive", 2, 1}, {"drive", 2, 2}});
  pending.push_back({"drive", 2, 1});
  EXPECT_EQ(controller.pending(), pending) << "as many as there is room for";
  state = {};
  controller.owe({{"drive", 2, 2}});
  EXPECT_EQ(controller.pending(), pending);
  EXPECT_TRUE(state.pending.empty()) << "it was not written";
  controller.settled({{"drive", 1, 1}}, [](const std::vector<Receipt>& before) { return before; });
  controller.owe({{"drive", 2, 2}});
  EXPECT_EQ(controller.pending().size(), kMostPendingEpochs);
  EXPECT_EQ(controller.pending().back(), (PendingEpoch{"drive", 2, 2}));
}

// A recording that has just ended matters more than the oldest; the caller reports the epochs that are given
// up.
TEST_F(SessionControllerTest, RestsThatAFullBookGivesUpAreNamed) {
  SessionController controller = this->controller();
  std::vector<PendingEpoch> pending;
  for (std::int64_t epoch = 1; epoch <= static_cast<std::int64_t>(kMostPendingEpochs); ++epoch)
    pending.push_back({"old", 1, epoch});
  controller.owe(pending);
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  const auto dropped = controller.ended({Receipt{.name = "drive"}}, {{"drive", 1, 900}, {"drive", 2, 77}},
                                        kNow, kNow / 1000 + 500);
  EXPECT_EQ(dropped, (std::vector<PendingEpoch>{{"old", 1, 1}, {"old", 1, 2}}));
  EXPECT_EQ(controller.pending().size(), kMostPendingEpochs);
  EXPECT_EQ(controller.pending().back(), (PendingEpoch{"drive", 2, 77}));
  controller.take(ask(Operation::kStart, 2, "next"), kNow, {2});
  EXPECT_TRUE(controller.ended({Receipt{.name = "next"}}, {}, kNow, kNow / 1000 + 500).empty());
}

// A full disk must not keep a recording from its end, nor a mark from the record.
TEST_F(SessionControllerTest, ABookThatCannotBeWrittenStopsNothingThatRuns) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  disk_fails = true;
  controller.take(ask(Operation::kMark, 2, "a"), kNow, {2});
  controller.take(ask(Operation::kStop, 3), kNow, {2});
  EXPECT_EQ(std::ranges::count(done, "mark 1 a"), 1);
  EXPECT_EQ(done.back(), "stop");
}

}  // namespace
}  // namespace roadbalance
