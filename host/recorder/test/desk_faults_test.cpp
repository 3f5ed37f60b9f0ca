#include <gtest/gtest.h>

#include <algorithm>

#include "host/recorder/test/desk_fixture.hpp"

namespace roadbalance {
namespace {

using test::ask, test::kNow, test::DeskTest;

TEST_F(DeskTest, AMarkIsDoneOnlyIfItIsOnTheDisk) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  desk.take(ask(Operation::kMark, 2), kNow, {2});
  desk.take(ask(Operation::kMark, 3), kNow, {2});
  desk.runs(true, 1, kNow);
  desk.take(ask(Operation::kStop, 4), kNow, {2});
  (void)desk.answers();
  desk.ended({}, {}, kNow, kNow / 1000 + 500);
  desk.take(ask(Operation::kMark, 2), kNow, {2});
  EXPECT_EQ(last(desk).state, AnswerState::kDone);
  desk.take(ask(Operation::kMark, 3), kNow, {2});
  const Answer lost = last(desk);
  EXPECT_EQ(lost.state, AnswerState::kRefused);
  EXPECT_EQ(lost.reason, RefusalReason::kDisk);
}

TEST_F(DeskTest, RefusesWhatCannotBeAndSaysWhy) {
  taken = {"drive"};
  Desk desk = this->desk();
  const auto reason = [&](const Request& request, int nodes) {
    desk.take(request, kNow, {nodes});
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

// The nodes get the new text only when the book says so: a recorder that is killed then knows what to undo.
TEST_F(DeskTest, ASetUpIsInTheBookBeforeItIsDoneAndAnsweredOnce) {
  Desk desk = this->desk();
  disk_fails = true;
  desk.take(ask(Operation::kRange, 1), kNow, {1});
  EXPECT_EQ(last(desk).reason, RefusalReason::kDisk);
  EXPECT_EQ(done, std::vector<std::string>{"forget"});
  disk_fails = false;
  Desk second = this->desk();
  second.take(ask(Operation::kRange, 1), kNow, {1});
  ASSERT_TRUE(book.set_up);
  EXPECT_EQ(book.set_up->vehicle_crc32c, 5u);
  Desk third = this->desk();  // it was killed
  third.take(ask(Operation::kRange, 1), kNow, {1});
  EXPECT_EQ(last(third).state, AnswerState::kUnderWay);
  third.was_set_up({.asker = 7,
                    .request = 1,
                    .operation = Operation::kRange,
                    .state = AnswerState::kRefused,
                    .reason = RefusalReason::kNotSupported,
                    .text = "undone"});
  Desk fourth = this->desk();
  fourth.take(ask(Operation::kRange, 1), kNow, {1});
  const Answer answer = last(fourth);
  EXPECT_EQ(answer.state, AnswerState::kRefused);
  EXPECT_EQ(answer.reason, RefusalReason::kNotSupported);
  EXPECT_EQ(answer.text, "undone");
}

// Killed at each step and begun anew, with the requester repeating what was not answered.
TEST_F(DeskTest, ARecorderThatIsKilledGoesOnWithWhatWasAsked) {
  desk().take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  {
    Desk second = desk();
    EXPECT_EQ(done.back(), "begin drive");
    second.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
    EXPECT_EQ(last(second).state, AnswerState::kUnderWay);
    second.runs(true, 0, kNow);
    EXPECT_EQ(last(second).state, AnswerState::kDone);
    second.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
  }
  done.clear();
  {
    Desk third = desk();
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
    Desk fourth = desk();
    const std::vector<std::string> expected{"begin drive", "stop"};
    EXPECT_EQ(done, expected);
    fourth.take(ask(Operation::kStop, 3), kNow, {2});
    fourth.ended({Receipt{.name = "drive"}}, {}, kNow, kNow / 1000 + 500);
    EXPECT_EQ(last(fourth).state, AnswerState::kDone);
  }
  Desk fifth = desk();
  EXPECT_FALSE(fifth.under_way());
  fifth.take(ask(Operation::kStop, 3), kNow, {2});
  EXPECT_EQ(last(fifth).state, AnswerState::kDone);
  fifth.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  EXPECT_EQ(last(fifth).state, AnswerState::kDone) << "a late repetition starts nothing";
  EXPECT_FALSE(fifth.under_way());
}

TEST_F(DeskTest, ARecordingThatFailsIsAFaultAndGoesOn) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  desk.runs(true, 0, kNow);
  desk.failed("the disk is gone", true, kNow);
  EXPECT_EQ(desk.fault(), "the disk is gone");
  ASSERT_TRUE(desk.under_way());
  desk.again();
  EXPECT_EQ(std::ranges::count(done, "begin drive"), 2);
  desk.runs(true, 0, kNow);
  EXPECT_EQ(desk.fault(), "");
}

TEST_F(DeskTest, AStartWhoseFolderCannotBeOpenedIsRefused) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  desk.failed("open drive: read-only", false, kNow);
  const Answer answer = last(desk);
  EXPECT_EQ(answer.state, AnswerState::kRefused);
  EXPECT_EQ(answer.reason, RefusalReason::kDisk);
  EXPECT_FALSE(desk.under_way());
  EXPECT_FALSE(book.under_way);
}

// A disk so slow that somebody stops the recording before it turns out that it cannot be begun.
TEST_F(DeskTest, AStopAndMarksOfARecordingThatIsGivenUpAreRefusedToo) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  desk.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
  desk.take(ask(Operation::kStop, 3), kNow, {2});
  (void)desk.answers();
  desk.failed("open drive: read-only", false, kNow);
  std::set<std::int64_t> refused;
  for (const Answer& answer : desk.answers()) {
    EXPECT_EQ(answer.state, AnswerState::kRefused);
    EXPECT_EQ(answer.reason, RefusalReason::kDisk);
    EXPECT_NE(answer.text.find("read-only"), std::string::npos) << answer.text;
    refused.insert(answer.request);
  }
  EXPECT_EQ(refused, (std::set<std::int64_t>{1, 2, 3}));
  desk.take(ask(Operation::kStop, 3), kNow, {2});
  EXPECT_EQ(last(desk).state, AnswerState::kRefused) << "whoever asks again hears it, too";
}

// Whoever asked repeats it until it is answered: that does not make this recorder the one that began it.
TEST_F(DeskTest, AStartThatWasTakenOverIsNeverRefusedForItMayHoldSamples) {
  desk().take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  Desk second = desk();
  second.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  second.failed("open drive: read-only", false, kNow);
  EXPECT_NE(last(second).state, AnswerState::kRefused);
  EXPECT_TRUE(second.under_way());
  EXPECT_TRUE(book.under_way);
}

// The disk fails over a stop for longer than the session waits, and still when it is begun again.
TEST_F(DeskTest, ARecordingThatHasRunIsNeverGivenUpHoweverOftenItFails) {
  for (const bool has_samples : {true, false}) {
    book = {};
    Desk desk = this->desk();
    desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
    desk.runs(has_samples, 0, kNow);
    desk.take(ask(Operation::kStop, 2), kNow, {2});
    desk.failed("sync: input/output error", true, kNow);
    (void)desk.answers();
    for (int k = 0; k < 3; ++k) {
      desk.again();
      desk.failed("open drive: read-only", false, kNow);
      ASSERT_TRUE(desk.under_way());
      ASSERT_TRUE(book.under_way);
      EXPECT_EQ(desk.fault(), "open drive: read-only");
      EXPECT_TRUE(desk.answers().empty());
    }
    desk.again();
    EXPECT_EQ(done.back(), "stop");
    desk.ended({Receipt{.name = "drive"}}, {{"drive", 2, 77}}, kNow, kNow / 1000 + 500);
    for (const Answer& answer : desk.answers()) EXPECT_EQ(answer.state, AnswerState::kDone) << answer.text;
    EXPECT_EQ(desk.rests(), (std::vector<Rest>{{"drive", 2, 77}}));
    desk.take(ask(Operation::kStart, 3, "next"), kNow, {2});
    desk.failed("open next: read-only", false, kNow);
    EXPECT_FALSE(desk.under_way()) << "that one is empty";
  }
}

// Whoever repeats a mark that is on the disk learns so; that the disk fails now remains true.
TEST_F(DeskTest, AMarkThatIsRepeatedEndsNoFault) {
  {
    Desk first = this->desk();
    first.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
    first.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
    first.runs(true, 1, kNow);
  }
  Desk desk = this->desk();
  desk.failed("open drive: read-only", false, kNow);
  desk.take(ask(Operation::kMark, 2, "bridge"), kNow, {2});
  EXPECT_EQ(last(desk).state, AnswerState::kDone);
  EXPECT_EQ(desk.fault(), "open drive: read-only");
}

// Otherwise a recorder that is killed later finds a recording in the book whose start was refused.
TEST_F(DeskTest, ABookThatCouldNotBeWrittenIsWrittenAgain) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  disk_fails = true;
  desk.failed("open drive: read-only", false, kNow);
  EXPECT_EQ(last(desk).state, AnswerState::kRefused);
  desk.write_again();
  EXPECT_TRUE(book.under_way) << "the disk still fails";
  disk_fails = false;
  desk.write_again();
  EXPECT_FALSE(book.under_way);
}

TEST_F(DeskTest, RemembersTheIncarnationsOfRecordingsThatAreOver) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  desk.ended({Receipt{.incarnation = kNow / 1000 + 500, .name = "drive"}}, {}, kNow, kNow / 1000 + 500);
  EXPECT_EQ(desk.over(), (std::vector<Over>{{"drive", kNow / 1000, kNow / 1000 + 500}}));
  desk.owe({{"drive", 2, 77}});
  EXPECT_EQ(this->desk().rests(), (std::vector<Rest>{{"drive", 2, 77}})) << "in the book";
}

// Owed again at each turn, for what is not in the book is unknown: nothing may be pushed out or written for
// it.
TEST_F(DeskTest, AFullBookOwesNothingMoreUntilThereIsRoom) {
  Desk desk = this->desk();
  std::vector<Rest> rests;
  for (std::int64_t epoch = 1; epoch < static_cast<std::int64_t>(kMostRests); ++epoch)
    rests.push_back({"drive", 1, epoch});
  desk.owe(rests);
  desk.owe({{"drive", 2, 1}, {"drive", 2, 2}});
  rests.push_back({"drive", 2, 1});
  EXPECT_EQ(desk.rests(), rests) << "as many as there is room for";
  book = {};
  desk.owe({{"drive", 2, 2}});
  EXPECT_EQ(desk.rests(), rests);
  EXPECT_TRUE(book.rest.empty()) << "it was not written";
  desk.settled({{"drive", 1, 1}}, [](const std::vector<Receipt>& before) { return before; });
  desk.owe({{"drive", 2, 2}});
  EXPECT_EQ(desk.rests().size(), kMostRests);
  EXPECT_EQ(desk.rests().back(), (Rest{"drive", 2, 2}));
}

// A recording that has just ended matters more than the oldest; whoever leads the desk says what is given up.
TEST_F(DeskTest, RestsThatAFullBookGivesUpAreNamed) {
  Desk desk = this->desk();
  std::vector<Rest> rests;
  for (std::int64_t epoch = 1; epoch <= static_cast<std::int64_t>(kMostRests); ++epoch)
    rests.push_back({"old", 1, epoch});
  desk.owe(rests);
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  const auto dropped =
      desk.ended({Receipt{.name = "drive"}}, {{"drive", 1, 900}, {"drive", 2, 77}}, kNow, kNow / 1000 + 500);
  EXPECT_EQ(dropped, (std::vector<Rest>{{"old", 1, 1}, {"old", 1, 2}}));
  EXPECT_EQ(desk.rests().size(), kMostRests);
  EXPECT_EQ(desk.rests().back(), (Rest{"drive", 2, 77}));
  desk.take(ask(Operation::kStart, 2, "next"), kNow, {2});
  EXPECT_TRUE(desk.ended({Receipt{.name = "next"}}, {}, kNow, kNow / 1000 + 500).empty());
}

// A full disk must not keep a recording from its end, nor a mark from the record.
TEST_F(DeskTest, ABookThatCannotBeWrittenStopsNothingThatRuns) {
  Desk desk = this->desk();
  desk.take(ask(Operation::kStart, 1, "drive"), kNow, {2});
  disk_fails = true;
  desk.take(ask(Operation::kMark, 2, "a"), kNow, {2});
  desk.take(ask(Operation::kStop, 3), kNow, {2});
  EXPECT_EQ(std::ranges::count(done, "mark 1 a"), 1);
  EXPECT_EQ(done.back(), "stop");
}

}  // namespace
}  // namespace roadbalance
