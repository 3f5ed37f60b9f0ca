#include <gtest/gtest.h>

#include <algorithm>

#include "common/config/section.hpp"
#include "host/recorder/control/test/session_fixture.hpp"

namespace roadbalance {
namespace {

using test::ask, test::kNow, test::SessionControllerTest;

TEST_F(SessionControllerTest, AStopNamesTheNodeWhoseEndIsMissing) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.take(ask(Operation::kStop, 2), kNow, {2});
  controller.ended(
      {Receipt{.nodes = 2, .node = 1, .sums_agree = true}, Receipt{.nodes = 2, .node = 2, .open_epochs = 1}},
      {{"drive", 2, 77}}, kNow, kNow / 1000 + 500);
  EXPECT_EQ(last(controller).text,
            "\"drive\" is on the disk; node 2 has not told all of it to its end: is it on, and its cable "
            "plugged in? What it holds is fetched when it is back");
  ASSERT_EQ(state.pending.size(), 1u) << "on the disk, for the recorder that comes after";
  EXPECT_EQ(state.pending.front(), (PendingEpoch{"drive", 2, 77}));
  const auto complete = [](std::vector<Receipt> before) {
    before.at(1).open_epochs = 0;
    return before;
  };
  controller.settled({{"drive", 2, 76}}, complete);
  EXPECT_EQ(controller.pending().size(), 1u) << "that is another epoch";
  controller.settled({{"drive", 2, 77}}, complete);
  EXPECT_TRUE(state.pending.empty());
}

TEST_F(SessionControllerTest, AStopNamesTheNodeWhoseEndContradictsItsBlocks) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.take(ask(Operation::kStop, 2), kNow, {2});
  controller.ended({Receipt{.nodes = 2, .node = 1}, Receipt{.nodes = 2, .node = 2, .sums_agree = false}}, {},
                   kNow, kNow / 1000 + 500);
  EXPECT_EQ(
      last(controller).text,
      "\"drive\" is on the disk; node 2: the blocks recorded are not those that its end sums up; rb verify "
      "says more");
}

TEST_F(SessionControllerTest, AStartWithoutARequestTakesNoNameThatIsTaken) {
  taken = {"near2"};
  SessionController controller = this->controller();
  EXPECT_THROW(controller.begin("near2", kNow), ConfigError);
  EXPECT_EQ(done, std::vector<std::string>{});
  EXPECT_FALSE(state.active);
  controller.begin("far", kNow);
  EXPECT_EQ(done, std::vector<std::string>{"begin far"});
}

TEST_F(SessionControllerTest, AStartWithoutOneOfItsNodesIsPartialAndSaysSoAtOnce) {
  chosen.missing = {{.number = 2, .name = "rear"}};
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {1});
  Answer answer = last(controller);
  EXPECT_EQ(answer.state, AnswerState::kUnderWay);
  EXPECT_EQ(answer.text,
            "waits for the first samples of \"drive\"; PARTIAL: node 2 (rear) is not on the bus");
  EXPECT_EQ(done.back(), "asked 1 start \"drive\"; PARTIAL: node 2 (rear) is not on the bus")
      << "in the record";
  controller.runs(true, 0, kNow);
  answer = last(controller);
  EXPECT_EQ(answer.state, AnswerState::kDone);
  EXPECT_EQ(answer.text, "\"drive\" is being recorded; PARTIAL: node 2 (rear) is not on the bus");
  EXPECT_EQ(answer.value[0], 1.0);
}

TEST_F(SessionControllerTest, AStartWaitsForANodeThatHasJustLeft) {
  chosen.missing = {{.number = 2, .name = "rear"}};
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {.there = 1, .returning = {2}});
  EXPECT_EQ(last(controller).state, AnswerState::kUnderWay);
  EXPECT_FALSE(controller.active());
  chosen.missing.clear();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  EXPECT_TRUE(controller.active());
}

TEST_F(SessionControllerTest, AStartOfNodesThatAreAllAbsentIsRefused) {
  chosen = {.nodes = {2}, .missing = {{.number = 2}}, .is_any_there = false};
  Request start = ask(Operation::kStart, 1, "drive");
  start.nodes = "rear";
  SessionController controller = this->controller();
  controller.take(start, kNow, {1});
  const Answer answer = last(controller);
  EXPECT_EQ(answer.reason, RefusalReason::kNoNode);
  EXPECT_EQ(answer.text, "node rear is not on the bus: is its rb-node running?");
}

TEST_F(SessionControllerTest, ARecordingKeepsItsNodesAndWhoStoppedIt) {
  chosen.nodes = {2};
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  Request stop = ask(Operation::kStop, 2);
  stop.who = "rb of anna at laptop";
  controller.take(stop, kNow, {2});
  EXPECT_EQ(stopped_by, "rb of anna at laptop");
  ASSERT_TRUE(state.active);
  EXPECT_EQ(state.active->nodes, std::vector<std::int32_t>{2});
  stopped_by.clear();
  SessionController after = this->controller();  // the one before was killed
  EXPECT_EQ(stopped_by, "rb of anna at laptop");
}

TEST_F(SessionControllerTest, ASignalStopsARecordingByName) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.end();
  EXPECT_EQ(stopped_by, kStoppedBySignal);
}

TEST_F(SessionControllerTest, RefusesMarksThatItCouldNotRemember) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  const auto most = static_cast<std::int32_t>(kMarksRemembered);
  for (std::int32_t k = 0; k < most; ++k) controller.take(ask(Operation::kMark, 100 + k), kNow, {2});
  EXPECT_EQ(last(controller).state, AnswerState::kUnderWay);
  controller.take(ask(Operation::kMark, 500), kNow, {2});
  EXPECT_EQ(last(controller).state, AnswerState::kRefused);
  controller.runs(true, most, kNow);
  controller.take(ask(Operation::kMark, 501), kNow, {2});
  EXPECT_EQ(last(controller).value[0], most + 1);
}

TEST_F(SessionControllerTest, StartsNothingWhileTheNodesAreBeingSetUp) {
  SessionController controller = this->controller();
  sets_up = true;
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  EXPECT_EQ(last(controller).state, AnswerState::kRefused);
  EXPECT_TRUE(done.empty());
  sets_up = false;
  controller.take(ask(Operation::kStart, 2, "drive"), kNow, {2});
  EXPECT_EQ(last(controller).state, AnswerState::kUnderWay);
}

TEST_F(SessionControllerTest, StartsMarksAndStops) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  EXPECT_EQ(last(controller).state, AnswerState::kUnderWay);
  controller.runs(false, 0, kNow);
  EXPECT_TRUE(controller.answers().empty()) << "nothing is recorded yet";
  controller.runs(true, 0, kNow);
  EXPECT_EQ(last(controller).state, AnswerState::kDone);
  controller.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
  EXPECT_EQ(last(controller).state, AnswerState::kUnderWay);
  controller.runs(true, 1, kNow);
  const Answer mark = last(controller);
  EXPECT_EQ(mark.state, AnswerState::kDone);
  EXPECT_EQ(mark.value[0], 1);
  controller.take(ask(Operation::kStop, 3), kNow, {2});
  EXPECT_EQ(last(controller).state, AnswerState::kUnderWay);
  controller.ended({Receipt{.name = "drive"}}, {}, kNow, kNow / 1000 + 500);
  EXPECT_EQ(last(controller).state, AnswerState::kDone);
  EXPECT_FALSE(controller.active());
  EXPECT_EQ(controller.finished()->receipt.front().name, "drive");
  const std::vector<std::string> expected{"begin drive", "asked 1 start \"drive\"", "mark 1 bridge",
                                          "asked 2 stop", "stop"};
  EXPECT_EQ(done, expected);
}

TEST_F(SessionControllerTest, ARepeatedRequestActsOnce) {
  SessionController controller = this->controller();
  for (int k = 0; k < 3; ++k) controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.runs(true, 0, kNow);
  for (int k = 0; k < 3; ++k) controller.take(ask(Operation::kMark, 2, "a"), kNow, {2});
  for (int k = 0; k < 3; ++k) controller.take(ask(Operation::kStop, 3), kNow, {2});
  EXPECT_EQ(std::ranges::count(done, "begin drive"), 1);
  EXPECT_EQ(std::ranges::count(done, "mark 1 a"), 1);
  EXPECT_EQ(std::ranges::count(done, "stop"), 1);
  controller.ended({}, {}, kNow, kNow / 1000 + 500);
  (void)controller.answers();
  controller.take(ask(Operation::kStop, 3), kNow, {2});
  EXPECT_EQ(last(controller).state, AnswerState::kDone);
}

// Its answer was lost, the recording was stopped, the recorder killed: who asks again hears what became of
// it.
TEST_F(SessionControllerTest, AMarkOfARecordingThatHasEndedKeepsItsLastWordInAnotherRecorder) {
  {
    SessionController controller = this->controller();
    controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
    controller.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
    controller.runs(true, 1, kNow);
    controller.take(ask(Operation::kMark, 3, "kerb"), kNow, {2});
    controller.take(ask(Operation::kStop, 4), kNow, {2});
    controller.ended({}, {}, kNow, kNow / 1000 + 500);
  }
  SessionController another = this->controller();
  another.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
  EXPECT_EQ(last(another).state, AnswerState::kDone);
  another.take(ask(Operation::kMark, 3, "kerb"), kNow, {2});
  const Answer unknown = last(another);
  EXPECT_EQ(unknown.state, AnswerState::kRefused);
  EXPECT_EQ(unknown.reason, RefusalReason::kDisk) << unknown.text;
  another.take(ask(Operation::kMark, 5, "later"), kNow, {2});
  EXPECT_EQ(last(another).reason, RefusalReason::kNotRecording);
}

// The commit that closes the record is the first with it.
TEST_F(SessionControllerTest, AMarkThatIsDurableAtTheEndOnlyIsDone) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
  controller.take(ask(Operation::kStop, 3), kNow, {2});
  controller.runs(true, 0, kNow);
  (void)controller.answers();
  controller.marks_are_durable(1);
  controller.ended({}, {}, kNow, kNow / 1000 + 500);
  const Answer mark = last(controller);
  EXPECT_EQ(mark.operation, Operation::kMark);
  EXPECT_EQ(mark.state, AnswerState::kDone) << mark.text;
}

TEST_F(SessionControllerTest, ASecondStartIsRefusedAndChangesNothing) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.take(ask(Operation::kStart, 2, "other"), kNow, {2});
  const Answer answer = last(controller);
  EXPECT_EQ(answer.state, AnswerState::kRefused);
  EXPECT_EQ(answer.reason, RefusalReason::kRecording);
  EXPECT_EQ(controller.active()->name, "drive");
  EXPECT_EQ(std::ranges::count_if(done, [](const auto& did) { return did.starts_with("begin"); }), 1);
}

TEST_F(SessionControllerTest, StopsARecordingThatHasNotBegunToRun) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.take(ask(Operation::kStop, 2), kNow, {2});
  (void)controller.answers();
  controller.ended({Receipt{.name = "drive"}}, {}, kNow, kNow / 1000 + 500);
  const auto answers = controller.answers();
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_EQ(answers[0].operation, Operation::kStart);
  EXPECT_EQ(answers[0].state, AnswerState::kDone);
  EXPECT_EQ(answers[1].operation, Operation::kStop);
  EXPECT_EQ(answers[1].state, AnswerState::kDone);
}

TEST_F(SessionControllerTest, ARecordingWithoutANameIsCalledByItsTime) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1), kNow, {1});
  EXPECT_EQ(controller.active()->name, "2026-01-31 12-00-05");
}

// With the end of a recording nodes leave, and are back some moments later.
TEST_F(SessionControllerTest, WaitsForNodesThatReturnInsteadOfRefusing) {
  SessionController controller = this->controller();
  for (const Request& request : {ask(Operation::kRange, 1), ask(Operation::kStart, 2, "drive")}) {
    controller.take(request, kNow, {0, {1, 2}});
    const Answer waits = last(controller);
    EXPECT_EQ(waits.request, request.request);
    EXPECT_EQ(waits.state, AnswerState::kUnderWay);
    EXPECT_EQ(waits.text, "waits for node 1, 2, which has just left, to return");
  }
  EXPECT_FALSE(state.set_up || state.active);
  EXPECT_TRUE(done.empty());
  // Half of the car is not set up; what is recorded need not wait.
  controller.take(ask(Operation::kRange, 1), kNow, {1, {2}});
  EXPECT_EQ(last(controller).text, "waits for node 2, which has just left, to return");
  controller.take(ask(Operation::kStart, 2, "drive"), kNow, {1, {2}});
  EXPECT_EQ(controller.active()->name, "drive");
  controller.take(ask(Operation::kRange, 1), kNow, {1, {2}});
  EXPECT_EQ(last(controller).reason, RefusalReason::kRecording);
  // Whoever does not return is waited for no longer.
  controller.take(ask(Operation::kStop, 3), kNow, {1});
  controller.ended({}, {}, kNow, kNow / 1000 + 500);
  controller.take(ask(Operation::kStart, 4, "next"), kNow, {0});
  EXPECT_EQ(last(controller).reason, RefusalReason::kNoNode);
}

TEST_F(SessionControllerTest, ASetUpIsForBetweenRecordings) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kRange, 1), kNow, {1});
  EXPECT_EQ(last(controller).state, AnswerState::kUnderWay);
  controller.was_set_up(
      {.asker = 7, .request = 1, .operation = Operation::kRange, .state = AnswerState::kDone});
  EXPECT_EQ(last(controller).state, AnswerState::kDone);
  controller.take(ask(Operation::kStart, 2, "drive"), kNow, {1});
  for (const auto operation :
       {Operation::kRange, Operation::kFilter, Operation::kZero, Operation::kVehicle}) {
    controller.take(ask(operation, 10 + static_cast<int>(operation)), kNow, {1});
    EXPECT_EQ(last(controller).reason, RefusalReason::kRecording);
  }
}

// Only then nodes send edges; each reading counts once, however often its request comes.
TEST_F(SessionControllerTest, ReadsAZeroMarkWhileARecordingIsUnderWay) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kReading, 1), kNow, {1});
  EXPECT_EQ(last(controller).reason, RefusalReason::kNotRecording);
  EXPECT_TRUE(done.empty());
  controller.take(ask(Operation::kStart, 2, "turned"), kNow, {1});
  done.clear();
  for (int k = 0; k < 2; ++k) {
    controller.take(ask(Operation::kReading, 3), kNow, {1});
    const Answer answer = last(controller);
    EXPECT_EQ(answer.state, AnswerState::kDone);
    EXPECT_EQ(answer.request, 3);
    EXPECT_EQ(answer.value, (std::array{0.5, 0.01}));
  }
  EXPECT_EQ(done, (std::vector<std::string>{"read", "asked 11 read"}))
      << "done once, and noted in the record";
  mark_fired = false;
  done.clear();
  controller.take(ask(Operation::kReading, 4), kNow, {1});
  EXPECT_EQ(last(controller).reason, RefusalReason::kMoving);
  EXPECT_EQ(done, (std::vector<std::string>{"read", "asked 11 refused: it turns"}));
  controller.take(ask(Operation::kDatum, 5), kNow, {1});
  EXPECT_EQ(last(controller).reason, RefusalReason::kRecording) << "a datum is for between recordings";
}

// Requests may come from anyone on the bus, and notes stay in memory while the disk fails.
TEST_F(SessionControllerTest, NotesAHundredReadingsAndAHundredOthersInASession) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "turned"), kNow, {1});
  done.clear();
  const auto notes = [&] {
    return std::ranges::count_if(done, [](const auto& what) { return what.starts_with("asked"); });
  };
  std::int64_t number = 2;
  const auto flood = [&](Request request) {
    for (int k = 0; k < 1000; ++k) {
      request.request = number++;
      controller.take(request, kNow, {1});
      (void)controller.answers();
    }
  };
  const Request begin = ask(Operation::kReading, 0);
  Request reading = begin;
  reading.value = {0.5, 1};
  flood(begin);
  EXPECT_EQ(notes(), 100);
  flood(ask(Operation::kStart, 0, "other"));  // refused
  EXPECT_EQ(notes(), 100);
  EXPECT_EQ(done[199], "asked 11 read (more like this is not noted)");
  flood(reading);
  EXPECT_EQ(notes(), 200) << "readings that count are in the record all the same";
}

// A node shows by a number only whose its samples are.
TEST_F(SessionControllerTest, NoTwoRecordingsHaveAnIncarnationInCommonThoughTheClockIsSetBack) {
  SessionController controller = this->controller();
  controller.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  controller.ended({}, {}, kNow, kNow / 1000 + 500);
  constexpr std::int64_t kDayBefore = kNow - 86'400'000'000;
  controller.take(ask(Operation::kStart, 2, "next"), kDayBefore, {2});
  const std::int64_t first = first_incarnation(*controller.active(), controller.past());
  EXPECT_EQ(first, kNow / 1000 + 501);
  controller.ended({}, {}, kDayBefore, first + 3);
  EXPECT_EQ(controller.past(), (std::vector<PastRecording>{{"drive", kNow / 1000, kNow / 1000 + 500},
                                                           {"next", first, first + 3}}));
}

}  // namespace
}  // namespace roadbalance
