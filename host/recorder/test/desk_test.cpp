#include "host/recorder/desk.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <set>
#include <system_error>

namespace roadbalance {
namespace {

constexpr std::int64_t kNow = 1'769'860'805'000'000;  // 2026-01-31 12:00:05 UTC, as date(1) says

Request ask(Operation operation, std::int64_t number, std::string text = "") {
  return {.asker = 7, .request = number, .operation = operation, .text = std::move(text)};
}

// What the desk's hands did, and a disk whose book outlives it.
class DeskTest : public ::testing::Test {
 protected:
  Desk desk() {
    return Desk({.store =
                     [this](const DeskBook& now) {
                       if (disk_fails) throw std::system_error(ENOSPC, std::generic_category(), "write book");
                       book = now;
                     },
                 .exists = [this](const std::string& name) { return taken.contains(name); },
                 .begin = [this](const UnderWay& of) { done.push_back("begin " + of.name); },
                 .stop = [this] { done.push_back("stop"); },
                 .note =
                     [this](const NoteToRecord& note) {
                       const char* kind = note.kind == NoteKind::kMark ? "mark " : "asked ";
                       done.push_back(kind + std::to_string(note.a) + " " + note.text);
                     },
                 .set_up =
                     [](const Request& request) {
                       return Answer{.asker = request.asker,
                                     .request = request.request,
                                     .operation = request.operation};
                     },
                 .is_set_up_under_way = [this] { return sets_up; }},
                book);
  }
  static Answer last(Desk& desk) {
    const auto answers = desk.answers();
    return answers.empty() ? Answer{} : answers.back();
  }

  DeskBook book;
  std::set<std::string> taken;
  std::vector<std::string> done;
  bool disk_fails = false;
  bool sets_up = false;
};

TEST_F(DeskTest, AMarkIsDoneOnlyIfItIsOnTheDisk) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  desk.take(ask(Operation::kMark, 2), kNow, 2);
  desk.take(ask(Operation::kMark, 3), kNow, 2);
  desk.runs(1, 1, kNow);
  desk.take(ask(Operation::kStop, 4), kNow, 2);
  (void)desk.answers();
  desk.ended({}, kNow);
  desk.take(ask(Operation::kMark, 2), kNow, 2);
  EXPECT_EQ(last(desk).state, AnswerState::kDone);
  desk.take(ask(Operation::kMark, 3), kNow, 2);
  const Answer lost = last(desk);
  EXPECT_EQ(lost.state, AnswerState::kRefused);
  EXPECT_EQ(lost.reason, RefusalReason::kDisk);
}

TEST_F(DeskTest, AStopNamesTheNodeWhoseEndIsMissing) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  desk.take(ask(Operation::kStop, 2), kNow, 2);
  desk.ended(
      {Receipt{.nodes = 2, .node = 1, .sums_agree = true}, Receipt{.nodes = 2, .node = 2, .open_epochs = 1}},
      kNow);
  EXPECT_EQ(last(desk).text,
            "\"drive\" is on the disk; node 2 has not told all of it to its end: is it on, and its cable "
            "plugged in?");
}

TEST_F(DeskTest, RefusesMarksThatItCouldNotRemember) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  const auto most = static_cast<std::int32_t>(kMarksRemembered);
  for (std::int32_t k = 0; k < most; ++k) desk.take(ask(Operation::kMark, 100 + k), kNow, 2);
  EXPECT_EQ(last(desk).state, AnswerState::kUnderWay);
  desk.take(ask(Operation::kMark, 500), kNow, 2);
  EXPECT_EQ(last(desk).state, AnswerState::kRefused);
  desk.runs(1, most, kNow);
  desk.take(ask(Operation::kMark, 501), kNow, 2);
  EXPECT_EQ(last(desk).value[0], most + 1);
}

TEST_F(DeskTest, StartsNothingWhileTheNodesAreBeingSetUp) {
  Desk desk = this->desk();
  sets_up = true;
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  EXPECT_EQ(last(desk).state, AnswerState::kRefused);
  EXPECT_TRUE(done.empty());
  sets_up = false;
  desk.take(ask(Operation::kStart, 2, "drive"), kNow, 2);
  EXPECT_EQ(last(desk).state, AnswerState::kUnderWay);
}

TEST_F(DeskTest, StartsMarksAndStops) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  EXPECT_EQ(last(desk).state, AnswerState::kUnderWay);
  desk.runs(0, 0, kNow);
  EXPECT_TRUE(desk.answers().empty()) << "nothing is recorded yet";
  desk.runs(1, 0, kNow);
  EXPECT_EQ(last(desk).state, AnswerState::kDone);
  desk.take(ask(Operation::kMark, 2, "bridge"), kNow, 2);
  EXPECT_EQ(last(desk).state, AnswerState::kUnderWay);
  desk.runs(1, 1, kNow);
  const Answer mark = last(desk);
  EXPECT_EQ(mark.state, AnswerState::kDone);
  EXPECT_EQ(mark.value[0], 1);
  desk.take(ask(Operation::kStop, 3), kNow, 2);
  EXPECT_EQ(last(desk).state, AnswerState::kUnderWay);
  desk.ended({Receipt{.name = "drive"}}, kNow);
  EXPECT_EQ(last(desk).state, AnswerState::kDone);
  EXPECT_FALSE(desk.under_way());
  EXPECT_EQ(desk.finished()->receipt.front().name, "drive");
  const std::vector<std::string> expected{"begin drive", "asked 1 start \"drive\"", "mark 1 bridge",
                                          "asked 2 stop", "stop"};
  EXPECT_EQ(done, expected);
}

TEST_F(DeskTest, ARepeatedRequestActsOnce) {
  Desk desk = this->desk();
  for (int k = 0; k < 3; ++k) desk.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  desk.runs(1, 0, kNow);
  for (int k = 0; k < 3; ++k) desk.take(ask(Operation::kMark, 2, "a"), kNow, 2);
  for (int k = 0; k < 3; ++k) desk.take(ask(Operation::kStop, 3), kNow, 2);
  EXPECT_EQ(std::ranges::count(done, "begin drive"), 1);
  EXPECT_EQ(std::ranges::count(done, "mark 1 a"), 1);
  EXPECT_EQ(std::ranges::count(done, "stop"), 1);
  desk.ended({}, kNow);
  (void)desk.answers();
  desk.take(ask(Operation::kStop, 3), kNow, 2);
  EXPECT_EQ(last(desk).state, AnswerState::kDone);
}

TEST_F(DeskTest, ASecondStartIsRefusedAndChangesNothing) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  desk.take(ask(Operation::kStart, 2, "other"), kNow, 2);
  const Answer answer = last(desk);
  EXPECT_EQ(answer.state, AnswerState::kRefused);
  EXPECT_EQ(answer.reason, RefusalReason::kRecording);
  EXPECT_EQ(desk.under_way()->name, "drive");
  EXPECT_EQ(std::ranges::count_if(done, [](const auto& did) { return did.starts_with("begin"); }), 1);
}

TEST_F(DeskTest, StopsARecordingThatHasNotBegunToRun) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  desk.take(ask(Operation::kStop, 2), kNow, 2);
  (void)desk.answers();
  desk.ended({Receipt{.name = "drive"}}, kNow);
  const auto answers = desk.answers();
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_EQ(answers[0].operation, Operation::kStart);
  EXPECT_EQ(answers[0].state, AnswerState::kDone);
  EXPECT_EQ(answers[1].operation, Operation::kStop);
  EXPECT_EQ(answers[1].state, AnswerState::kDone);
}

TEST_F(DeskTest, RefusesWhatCannotBeAndSaysWhy) {
  taken = {"drive"};
  Desk desk = this->desk();
  const auto reason = [&](const Request& request, int nodes) {
    desk.take(request, kNow, nodes);
    const Answer answer = last(desk);
    EXPECT_EQ(answer.state, AnswerState::kRefused);
    EXPECT_FALSE(answer.text.empty());
    return answer.reason;
  };
  EXPECT_EQ(reason(ask(Operation::kStart, 1, "drive"), 2), RefusalReason::kNameTaken);
  EXPECT_EQ(reason(ask(Operation::kStart, 2, "../drive"), 2), RefusalReason::kBadArgument);
  EXPECT_EQ(reason(ask(Operation::kStart, 3, ".."), 2), RefusalReason::kBadArgument);
  EXPECT_EQ(reason(ask(Operation::kStart, 4, kDeskBookFile), 2), RefusalReason::kBadArgument);
  EXPECT_EQ(reason(ask(Operation::kStart, 5, std::string(65, 'x')), 2), RefusalReason::kBadArgument);
  EXPECT_EQ(reason(ask(Operation::kStart, 6, "new"), 0), RefusalReason::kNoNode);
  EXPECT_EQ(reason(ask(Operation::kStop, 7), 2), RefusalReason::kNotRecording);
  EXPECT_EQ(reason(ask(Operation::kMark, 8), 2), RefusalReason::kNotRecording);
  EXPECT_EQ(reason(ask(static_cast<Operation>(99), 9), 2), RefusalReason::kUnknownOperation);
  disk_fails = true;
  EXPECT_EQ(reason(ask(Operation::kStart, 10, "new"), 2), RefusalReason::kDisk);
  EXPECT_TRUE(done.empty());
}

TEST_F(DeskTest, ARecordingWithoutANameIsCalledByItsTime) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1), kNow, 1);
  EXPECT_EQ(desk.under_way()->name, "2026-01-31 12-00-05");
}

TEST_F(DeskTest, ASetUpIsForBetweenRecordings) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kRange, 1), kNow, 1);
  EXPECT_EQ(last(desk).state, AnswerState::kUnderWay);
  desk.was_set_up({.asker = 7, .request = 1, .operation = Operation::kRange, .state = AnswerState::kDone});
  EXPECT_EQ(last(desk).state, AnswerState::kDone);
  desk.take(ask(Operation::kStart, 2, "drive"), kNow, 1);
  for (const auto operation :
       {Operation::kRange, Operation::kFilter, Operation::kZero, Operation::kVehicle}) {
    desk.take(ask(operation, 10 + static_cast<int>(operation)), kNow, 1);
    EXPECT_EQ(last(desk).reason, RefusalReason::kRecording);
  }
}

// Killed at each step and begun anew, with the requester repeating what was not answered.
TEST_F(DeskTest, ARecorderThatIsKilledGoesOnWithWhatWasAsked) {
  desk().take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  {
    Desk second = desk();
    EXPECT_EQ(done.back(), "begin drive");
    second.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
    EXPECT_EQ(last(second).state, AnswerState::kUnderWay);
    second.runs(1, 0, kNow);
    EXPECT_EQ(last(second).state, AnswerState::kDone);
    second.take(ask(Operation::kMark, 2, "bridge"), kNow, 2);
  }
  done.clear();
  {
    Desk third = desk();
    const std::vector<std::string> expected{"begin drive", "mark 1 bridge"};
    EXPECT_EQ(done, expected) << "it may not be on the disk";
    third.take(ask(Operation::kMark, 2, "bridge"), kNow, 2);
    EXPECT_EQ(last(third).value[0], 1);
    third.runs(1, 1, kNow);
    EXPECT_EQ(last(third).state, AnswerState::kDone);
    third.take(ask(Operation::kStop, 3), kNow, 2);
  }
  done.clear();
  {
    Desk fourth = desk();
    const std::vector<std::string> expected{"begin drive", "stop"};
    EXPECT_EQ(done, expected);
    fourth.take(ask(Operation::kStop, 3), kNow, 2);
    fourth.ended({Receipt{.name = "drive"}}, kNow);
    EXPECT_EQ(last(fourth).state, AnswerState::kDone);
  }
  Desk fifth = desk();
  EXPECT_FALSE(fifth.under_way());
  fifth.take(ask(Operation::kStop, 3), kNow, 2);
  EXPECT_EQ(last(fifth).state, AnswerState::kDone);
  fifth.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  EXPECT_EQ(last(fifth).state, AnswerState::kDone) << "a late repetition starts nothing";
  EXPECT_FALSE(fifth.under_way());
}

TEST_F(DeskTest, ARecordingThatFailsIsAFaultAndGoesOn) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  desk.runs(1, 0, kNow);
  desk.failed("the disk is gone", true, kNow);
  EXPECT_EQ(desk.fault(), "the disk is gone");
  ASSERT_TRUE(desk.under_way());
  desk.again();
  EXPECT_EQ(std::ranges::count(done, "begin drive"), 2);
  desk.runs(1, 0, kNow);
  EXPECT_EQ(desk.fault(), "");
}

TEST_F(DeskTest, AStartWhoseFolderCannotBeOpenedIsRefused) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  desk.failed("open drive: read-only", false, kNow);
  const Answer answer = last(desk);
  EXPECT_EQ(answer.state, AnswerState::kRefused);
  EXPECT_EQ(answer.reason, RefusalReason::kDisk);
  EXPECT_FALSE(desk.under_way());
  EXPECT_FALSE(book.under_way);
}

// A full disk must not keep a recording from its end, nor a mark from the record.
TEST_F(DeskTest, ABookThatCannotBeWrittenStopsNothingThatRuns) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, 2);
  disk_fails = true;
  desk.take(ask(Operation::kMark, 2, "a"), kNow, 2);
  desk.take(ask(Operation::kStop, 3), kNow, 2);
  EXPECT_EQ(std::ranges::count(done, "mark 1 a"), 1);
  EXPECT_EQ(done.back(), "stop");
}

}  // namespace
}  // namespace roadbalance
