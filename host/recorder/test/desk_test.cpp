#include <gtest/gtest.h>

#include <algorithm>

#include "host/recorder/test/desk_fixture.hpp"

namespace roadbalance {
namespace {

using test::ask, test::kNow, test::DeskTest;

TEST_F(DeskTest, AStopNamesTheNodeWhoseEndIsMissing) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  desk.take(ask(Operation::kStop, 2), kNow, {2});
  desk.ended(
      {Receipt{.nodes = 2, .node = 1, .sums_agree = true}, Receipt{.nodes = 2, .node = 2, .open_epochs = 1}},
      {{"drive", 2, 77}}, kNow, kNow / 1000 + 500);
  EXPECT_EQ(last(desk).text,
            "\"drive\" is on the disk; node 2 has not told all of it to its end: is it on, and its cable "
            "plugged in? What it holds is fetched when it is back");
  ASSERT_EQ(book.rest.size(), 1u) << "on the disk, for the recorder that comes after";
  EXPECT_EQ(book.rest.front(), (Rest{"drive", 2, 77}));
  const auto complete = [](std::vector<Receipt> before) {
    before.at(1).open_epochs = 0;
    return before;
  };
  desk.settled({{"drive", 2, 76}}, complete);
  EXPECT_EQ(desk.rests().size(), 1u) << "that is another epoch";
  desk.settled({{"drive", 2, 77}}, complete);
  EXPECT_TRUE(book.rest.empty());
}

TEST_F(DeskTest, AStopNamesTheNodeWhoseEndContradictsItsBlocks) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  desk.take(ask(Operation::kStop, 2), kNow, {2});
  desk.ended({Receipt{.nodes = 2, .node = 1}, Receipt{.nodes = 2, .node = 2, .sums_agree = false}}, {}, kNow,
             kNow / 1000 + 500);
  EXPECT_EQ(
      last(desk).text,
      "\"drive\" is on the disk; node 2: the blocks recorded are not those that its end sums up; rb verify "
      "says more");
}

TEST_F(DeskTest, RefusesMarksThatItCouldNotRemember) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  const auto most = static_cast<std::int32_t>(kMarksRemembered);
  for (std::int32_t k = 0; k < most; ++k) desk.take(ask(Operation::kMark, 100 + k), kNow, {2});
  EXPECT_EQ(last(desk).state, AnswerState::kUnderWay);
  desk.take(ask(Operation::kMark, 500), kNow, {2});
  EXPECT_EQ(last(desk).state, AnswerState::kRefused);
  desk.runs(true, most, kNow);
  desk.take(ask(Operation::kMark, 501), kNow, {2});
  EXPECT_EQ(last(desk).value[0], most + 1);
}

TEST_F(DeskTest, StartsNothingWhileTheNodesAreBeingSetUp) {
  Desk desk = this->desk();
  sets_up = true;
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  EXPECT_EQ(last(desk).state, AnswerState::kRefused);
  EXPECT_TRUE(done.empty());
  sets_up = false;
  desk.take(ask(Operation::kStart, 2, "drive"), kNow, {2});
  EXPECT_EQ(last(desk).state, AnswerState::kUnderWay);
}

TEST_F(DeskTest, StartsMarksAndStops) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  EXPECT_EQ(last(desk).state, AnswerState::kUnderWay);
  desk.runs(false, 0, kNow);
  EXPECT_TRUE(desk.answers().empty()) << "nothing is recorded yet";
  desk.runs(true, 0, kNow);
  EXPECT_EQ(last(desk).state, AnswerState::kDone);
  desk.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
  EXPECT_EQ(last(desk).state, AnswerState::kUnderWay);
  desk.runs(true, 1, kNow);
  const Answer mark = last(desk);
  EXPECT_EQ(mark.state, AnswerState::kDone);
  EXPECT_EQ(mark.value[0], 1);
  desk.take(ask(Operation::kStop, 3), kNow, {2});
  EXPECT_EQ(last(desk).state, AnswerState::kUnderWay);
  desk.ended({Receipt{.name = "drive"}}, {}, kNow, kNow / 1000 + 500);
  EXPECT_EQ(last(desk).state, AnswerState::kDone);
  EXPECT_FALSE(desk.under_way());
  EXPECT_EQ(desk.finished()->receipt.front().name, "drive");
  const std::vector<std::string> expected{"begin drive", "asked 1 start \"drive\"", "mark 1 bridge",
                                          "asked 2 stop", "stop"};
  EXPECT_EQ(done, expected);
}

TEST_F(DeskTest, ARepeatedRequestActsOnce) {
  Desk desk = this->desk();
  for (int k = 0; k < 3; ++k) desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  desk.runs(true, 0, kNow);
  for (int k = 0; k < 3; ++k) desk.take(ask(Operation::kMark, 2, "a"), kNow, {2});
  for (int k = 0; k < 3; ++k) desk.take(ask(Operation::kStop, 3), kNow, {2});
  EXPECT_EQ(std::ranges::count(done, "begin drive"), 1);
  EXPECT_EQ(std::ranges::count(done, "mark 1 a"), 1);
  EXPECT_EQ(std::ranges::count(done, "stop"), 1);
  desk.ended({}, {}, kNow, kNow / 1000 + 500);
  (void)desk.answers();
  desk.take(ask(Operation::kStop, 3), kNow, {2});
  EXPECT_EQ(last(desk).state, AnswerState::kDone);
}

// Its answer was lost, the recording was stopped, the recorder killed: who asks again hears what became of
// it.
TEST_F(DeskTest, AMarkOfARecordingThatHasEndedKeepsItsLastWordInAnotherRecorder) {
  {
    Desk desk = this->desk();
    desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
    desk.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
    desk.runs(true, 1, kNow);
    desk.take(ask(Operation::kMark, 3, "kerb"), kNow, {2});
    desk.take(ask(Operation::kStop, 4), kNow, {2});
    desk.ended({}, {}, kNow, kNow / 1000 + 500);
  }
  Desk another = this->desk();
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
TEST_F(DeskTest, AMarkThatIsDurableAtTheEndOnlyIsDone) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  desk.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
  desk.take(ask(Operation::kStop, 3), kNow, {2});
  desk.runs(true, 0, kNow);
  (void)desk.answers();
  desk.marks_are_durable(1);
  desk.ended({}, {}, kNow, kNow / 1000 + 500);
  const Answer mark = last(desk);
  EXPECT_EQ(mark.operation, Operation::kMark);
  EXPECT_EQ(mark.state, AnswerState::kDone) << mark.text;
}

TEST_F(DeskTest, ASecondStartIsRefusedAndChangesNothing) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  desk.take(ask(Operation::kStart, 2, "other"), kNow, {2});
  const Answer answer = last(desk);
  EXPECT_EQ(answer.state, AnswerState::kRefused);
  EXPECT_EQ(answer.reason, RefusalReason::kRecording);
  EXPECT_EQ(desk.under_way()->name, "drive");
  EXPECT_EQ(std::ranges::count_if(done, [](const auto& did) { return did.starts_with("begin"); }), 1);
}

TEST_F(DeskTest, StopsARecordingThatHasNotBegunToRun) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  desk.take(ask(Operation::kStop, 2), kNow, {2});
  (void)desk.answers();
  desk.ended({Receipt{.name = "drive"}}, {}, kNow, kNow / 1000 + 500);
  const auto answers = desk.answers();
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_EQ(answers[0].operation, Operation::kStart);
  EXPECT_EQ(answers[0].state, AnswerState::kDone);
  EXPECT_EQ(answers[1].operation, Operation::kStop);
  EXPECT_EQ(answers[1].state, AnswerState::kDone);
}

TEST_F(DeskTest, ARecordingWithoutANameIsCalledByItsTime) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1), kNow, {1});
  EXPECT_EQ(desk.under_way()->name, "2026-01-31 12-00-05");
}

// With the end of a recording nodes leave, and are back some moments later.
TEST_F(DeskTest, WaitsForNodesThatReturnInsteadOfRefusing) {
  Desk desk = this->desk();
  for (const Request& request : {ask(Operation::kRange, 1), ask(Operation::kStart, 2, "drive")}) {
    desk.take(request, kNow, {0, {1, 2}});
    const Answer waits = last(desk);
    EXPECT_EQ(waits.request, request.request);
    EXPECT_EQ(waits.state, AnswerState::kUnderWay);
    EXPECT_EQ(waits.text, "waits for node 1, 2, which has just left, to return");
  }
  EXPECT_FALSE(book.set_up || book.under_way);
  EXPECT_TRUE(done.empty());
  // Half of the car is not set up; what is recorded need not wait.
  desk.take(ask(Operation::kRange, 1), kNow, {1, {2}});
  EXPECT_EQ(last(desk).text, "waits for node 2, which has just left, to return");
  desk.take(ask(Operation::kStart, 2, "drive"), kNow, {1, {2}});
  EXPECT_EQ(desk.under_way()->name, "drive");
  desk.take(ask(Operation::kRange, 1), kNow, {1, {2}});
  EXPECT_EQ(last(desk).reason, RefusalReason::kRecording);
  // Whoever does not return is waited for no longer.
  desk.take(ask(Operation::kStop, 3), kNow, {1});
  desk.ended({}, {}, kNow, kNow / 1000 + 500);
  desk.take(ask(Operation::kStart, 4, "next"), kNow, {0});
  EXPECT_EQ(last(desk).reason, RefusalReason::kNoNode);
}

TEST_F(DeskTest, ASetUpIsForBetweenRecordings) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kRange, 1), kNow, {1});
  EXPECT_EQ(last(desk).state, AnswerState::kUnderWay);
  desk.was_set_up({.asker = 7, .request = 1, .operation = Operation::kRange, .state = AnswerState::kDone});
  EXPECT_EQ(last(desk).state, AnswerState::kDone);
  desk.take(ask(Operation::kStart, 2, "drive"), kNow, {1});
  for (const auto operation :
       {Operation::kRange, Operation::kFilter, Operation::kZero, Operation::kVehicle}) {
    desk.take(ask(operation, 10 + static_cast<int>(operation)), kNow, {1});
    EXPECT_EQ(last(desk).reason, RefusalReason::kRecording);
  }
}

// Only then nodes send edges; each reading counts once, however often its request comes.
TEST_F(DeskTest, ReadsAZeroMarkWhileARecordingIsUnderWay) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kReading, 1), kNow, {1});
  EXPECT_EQ(last(desk).reason, RefusalReason::kNotRecording);
  EXPECT_TRUE(done.empty());
  desk.take(ask(Operation::kStart, 2, "turned"), kNow, {1});
  done.clear();
  for (int k = 0; k < 2; ++k) {
    desk.take(ask(Operation::kReading, 3), kNow, {1});
    const Answer answer = last(desk);
    EXPECT_EQ(answer.state, AnswerState::kDone);
    EXPECT_EQ(answer.request, 3);
    EXPECT_EQ(answer.value, (std::array{0.5, 0.01}));
  }
  EXPECT_EQ(done, (std::vector<std::string>{"read", "asked 11 read"}))
      << "done once, and noted in the record";
  mark_fired = false;
  done.clear();
  desk.take(ask(Operation::kReading, 4), kNow, {1});
  EXPECT_EQ(last(desk).reason, RefusalReason::kMoving);
  EXPECT_EQ(done, (std::vector<std::string>{"read", "asked 11 refused: it turns"}));
  desk.take(ask(Operation::kDatum, 5), kNow, {1});
  EXPECT_EQ(last(desk).reason, RefusalReason::kRecording) << "a datum is for between recordings";
}

// Requests come from whoever is on the bus, and notes stay in memory while the disk fails.
TEST_F(DeskTest, NotesAHundredReadingsAndAHundredOthersInASession) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "turned"), kNow, {1});
  done.clear();
  const auto notes = [&] {
    return std::ranges::count_if(done, [](const auto& what) { return what.starts_with("asked"); });
  };
  std::int64_t number = 2;
  const auto flood = [&](Request request) {
    for (int k = 0; k < 1000; ++k) {
      request.request = number++;
      desk.take(request, kNow, {1});
      (void)desk.answers();
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

// A node says by a number only whose its samples are.
TEST_F(DeskTest, NoTwoRecordingsHaveAnIncarnationInCommonThoughTheClockIsSetBack) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  desk.ended({}, {}, kNow, kNow / 1000 + 500);
  constexpr std::int64_t kDayBefore = kNow - 86'400'000'000;
  desk.take(ask(Operation::kStart, 2, "next"), kDayBefore, {2});
  const std::int64_t first = first_incarnation(*desk.under_way(), desk.over());
  EXPECT_EQ(first, kNow / 1000 + 501);
  desk.ended({}, {}, kDayBefore, first + 3);
  EXPECT_EQ(desk.over(),
            (std::vector<Over>{{"drive", kNow / 1000, kNow / 1000 + 500}, {"next", first, first + 3}}));
}

}  // namespace
}  // namespace roadbalance
