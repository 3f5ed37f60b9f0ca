#include "host/recorder/desk_book.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

TEST(DeskBook, IsReadAsItWasWritten) {
  const test::TemporaryDirectory folder;
  EXPECT_FALSE(read_desk_book(folder.path()).under_way);
  DeskBook book{
      .under_way = UnderWay{.name = "Fahrt 1 ä",
                            .began_us = 5,
                            .start = {1, 2},
                            .stop = RequestKey{3, 4},
                            .marks = 9,
                            .durable_marks = 8,
                            .mark = {{.number = 9, .asked = {5, 6}, .text = "\"bridge\""}}},
      .finished = Finished{.start = {7, 8}, .stop = {9, 10}, .receipt = {Receipt{.name = "before"}}},
      .rest = {{"Fahrt 0", 2, 1LL << 60}},
      .over = {{"Fahrt 0", 1LL << 50, 1LL << 51}},
      .set_up = AskedSetUp{.asked = {11, 12},
                           .operation = Operation::kFilter,
                           .node = 1,
                           .channel = 2,
                           .value = {150.25, 4},
                           .nodes = {1, 2},
                           .vehicle_crc32c = 0xFFFFFFFF,
                           .state = AnswerState::kRefused,
                           .reason = RefusalReason::kNoAnswer,
                           .text = "no"}};
  write_desk_book(folder.path(), book);
  const DeskBook read = read_desk_book(folder.path());
  ASSERT_TRUE(read.under_way && read.finished);
  EXPECT_EQ(read.under_way->name, "Fahrt 1 ä");
  EXPECT_EQ(read.under_way->stop, (RequestKey{3, 4}));
  EXPECT_EQ(read.under_way->durable_marks, 8);
  ASSERT_EQ(read.under_way->mark.size(), 1u);
  EXPECT_EQ(read.under_way->mark[0].text, "\"bridge\"");
  EXPECT_EQ(read.finished->stop, (RequestKey{9, 10}));
  ASSERT_EQ(read.finished->receipt.size(), 1u);
  EXPECT_EQ(read.finished->receipt[0].name, "before");
  EXPECT_EQ(read.rest, book.rest);
  EXPECT_EQ(read.over, book.over);
  ASSERT_TRUE(read.set_up);
  EXPECT_EQ(*read.set_up, *book.set_up);
}

// What is no book is an error that names it: to begin with an empty one would end a recording unasked.
TEST(DeskBook, RefusesWhatIsNone) {
  const test::TemporaryDirectory folder;
  for (const char* text : {"", "{", "[]x", R"({"under_way": {}})",
                           R"({"under_way": {"name": "../x", "began_us": 1, "start": [1, 2], "marks": 0,
                               "durable_marks": 0, "mark": []}})"}) {
    std::ofstream(folder.path() / kDeskBookFile) << text;
    try {
      read_desk_book(folder.path());
      ADD_FAILURE() << text;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(kDeskBookFile), std::string::npos);
    }
  }
}

// The folder of a recording stands beside them.
TEST(DeskBook, NoRecordingIsCalledLikeAFileOfTheRecorder) {
  for (const char* own : {"recorder.json", "recorder.json.new", "vehicle", "vehicle.new"})
    EXPECT_NE(fault_of_name(own), "") << own;
  for (const char* free : {"recorder", "vehicles", "my vehicle", "new"})
    EXPECT_EQ(fault_of_name(free), "") << free;
}

// The start was refused because of the disk; asked again it must not be told of a recording that nobody made.
TEST(DeskBook, AStartThatCameToNothingLeavesItsNameFree) {
  const test::TemporaryDirectory all;
  const auto folder = all.path() / "drive", fallback = all.path() / "fallback";
  EXPECT_FALSE(is_taken(folder, "", {}));
  std::filesystem::create_directory(folder);
  EXPECT_FALSE(is_taken(folder, "", {}));
  for (const char* file : {"incarnation", "incarnation.new", "seg-000001.lcm.new"})
    std::ofstream(folder / file) << "7\n";
  EXPECT_FALSE(is_taken(folder, fallback, {{"drive 0", 1, 2}}));
  EXPECT_TRUE(is_taken(folder, "", {{"drive", 1, 2}})) << "a node may hold a rest of it";
  std::filesystem::create_directory(fallback);
  EXPECT_TRUE(is_taken(folder, fallback, {})) << "it may be recorded there";
}

TEST(DeskBook, WhateverElseIsThereTakesAName) {
  for (const char* file : {"seg-000001.lcm", "seg-000001.tail", "continued-in", "notes.txt"}) {
    const test::TemporaryDirectory folder;
    std::ofstream(folder.path() / file) << "";
    EXPECT_TRUE(is_taken(folder.path(), "", {})) << file;
    EXPECT_TRUE(is_taken(folder.path() / file, "", {})) << "a file";
  }
}

}  // namespace
}  // namespace roadbalance
