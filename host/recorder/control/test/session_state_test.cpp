#include "host/recorder/control/session_state.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "common/bus/wire_text.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

TEST(SessionState, IsReadAsItWasWritten) {
  const test::TemporaryDirectory folder;
  EXPECT_FALSE(read_session_state(folder.path()).active);
  SessionState state{
      .active = ActiveRecording{.name = "Fahrt 1 ä",
                                .began_us = 5,
                                .start = {1, 2},
                                .stop = RequestKey{3, 4},
                                .marks = 9,
                                .durable_marks = 8,
                                .mark = {{.number = 9, .asked = {5, 6}, .text = "\"bridge\""}}},
      .finished = Finished{.start = {7, 8},
                           .stop = {9, 10},
                           .receipt = {Receipt{.name = "before"}},
                           .durable_marks = 3,
                           .mark = {{.number = 4, .asked = {7, 11}, .text = "kerb"}}},
      .pending = {{"Fahrt 0", 2, 1LL << 60}},
      .past = {{"Fahrt 0", 1LL << 50, 1LL << 51}},
      .set_up = AskedSetUp{.asked = {11, 12},
                           .operation = Operation::kFilter,
                           .node = 1,
                           .channel = 2,
                           .value = {150.25, 4},
                           .nodes = {1, 2},
                           .vehicle_crc32c = 0xFFFFFFFF,
                           .state = AnswerState::kRefused,
                           .reason = RefusalReason::kNoAnswer,
                           .text = "no"},
      .set_up_before = {AskedSetUp{.asked = {11, 10}, .state = AnswerState::kDone, .text = "yes"}}};
  write_session_state(folder.path(), state);
  const SessionState read = read_session_state(folder.path());
  ASSERT_TRUE(read.active && read.finished);
  EXPECT_EQ(read.active->name, "Fahrt 1 ä");
  EXPECT_EQ(read.active->stop, (RequestKey{3, 4}));
  EXPECT_EQ(read.active->durable_marks, 8);
  ASSERT_EQ(read.active->mark.size(), 1u);
  EXPECT_EQ(read.active->mark[0].text, "\"bridge\"");
  EXPECT_EQ(read.finished->stop, (RequestKey{9, 10}));
  ASSERT_EQ(read.finished->receipt.size(), 1u);
  EXPECT_EQ(read.finished->receipt[0].name, "before");
  EXPECT_EQ(read.finished->durable_marks, 3);
  ASSERT_EQ(read.finished->mark.size(), 1u);
  EXPECT_EQ(read.finished->mark[0].number, 4);
  EXPECT_EQ(read.finished->mark[0].asked, (RequestKey{7, 11}));
  EXPECT_EQ(read.pending, state.pending);
  EXPECT_EQ(read.past, state.past);
  ASSERT_TRUE(read.set_up);
  EXPECT_EQ(*read.set_up, *state.set_up);
  EXPECT_EQ(read.set_up_before, state.set_up_before);
}

// A file that holds no session state is an error that names it: to begin with an empty one would end a
// recording unasked.
TEST(SessionState, RefusesWhatIsNone) {
  const test::TemporaryDirectory folder;
  for (const char* text : {"", "{", "[]x", R"({"under_way": {}})",
                           R"({"under_way": {"name": "../x", "began_us": 1, "start": [1, 2], "marks": 0,
                               "durable_marks": 0, "mark": []}})"}) {
    std::ofstream(folder.path() / kSessionStateFile) << text;
    try {
      read_session_state(folder.path());
      ADD_FAILURE() << text;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(kSessionStateFile), std::string::npos);
    }
  }
}

TEST(SessionState, ARefusalRepeatsNothingThatATerminalObeys) {
  const test::TemporaryDirectory folder;
  for (const char* text : {"{\"a\xFF\": 1}", "{\"a\033[2J\": 1}", "\033[2J"}) {
    std::ofstream(folder.path() / kSessionStateFile) << text;
    try {
      read_session_state(folder.path());
      ADD_FAILURE() << text;
    } catch (const std::runtime_error& error) {
      EXPECT_TRUE(wire_text::is_plain_text(error.what())) << error.what();
    }
  }
}

/// Each is valid JSON, and one value of it is none of its kind.
TEST(SessionState, RefusesAValueThatCannotBeAndNamesIt) {
  const test::TemporaryDirectory folder;
  const std::string good =
      R"({"under_way": {"name": "drive", "began_us": 5, "start": [1, 2], "marks": 9, "durable_marks": 8,
                        "mark": [[9, [3, 4], "bridge"]], "stop": [5, 6]},
          "finished": {"start": [1, 2], "stop": [3, 4], "receipt": ["00ff"]},
          "set_up": {"asked": [1, 2], "operation": 4, "node": 1, "channel": -1, "value": [1.5, 2], "nodes": [1, 2],
                     "vehicle_crc32c": 4294967295, "state": 2, "reason": 0, "text": "done"},
          "rest": [["before", 2, -77]], "over": [["before", 1000, 2000]]})";
  const auto refusal = [&](const std::string& text) -> std::string {
    std::ofstream(folder.path() / kSessionStateFile) << text;
    try {
      read_session_state(folder.path());
      return "";
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(kSessionStateFile), std::string::npos) << error.what();
      return error.what();
    }
  };
  ASSERT_EQ(refusal(good), "");
  struct Spoilt {
    const char *from, *to, *named;
  };
  for (const Spoilt& one :
       {Spoilt{"\"began_us\": 5", "\"began_us\": 4e52", "under_way: began_us: "},
        {"\"began_us\": 5", "\"began_us\": 9223372036854775807", "under_way: began_us: "},
        {"\"start\": [1, 2], \"marks\"", "\"start\": [1, 1.5], \"marks\"", "under_way: start: "},
        {"\"marks\": 9", "\"marks\": 4e52", "under_way: marks: "},
        {"\"marks\": 9", "\"marks\": 2147483647", "under_way: marks: "},
        {"\"durable_marks\": 8", "\"durable_marks\": -8", "under_way: durable_marks: "},
        {"[[9, [3", "[[-1e99, [3", "under_way: mark: "},
        {"\"bridge\"", "7", "under_way: mark: "},
        {"\"stop\": [5, 6]", "\"stop\": [5]", "under_way: stop: "},
        {"\"00ff\"", "\"-1ff\"", "finished: receipt: "},
        {"\"00ff\"", "\" 1ff\"", "finished: receipt: "},
        {"\"00ff\"", "\"0x\"", "finished: receipt: "},
        {"\"00ff\"", "\"00f\"", "finished: receipt: "},
        {"\"operation\": 4", "\"operation\": 13", "set_up: operation: "},
        {"\"node\": 1", "\"node\": 10000", "set_up: node: "},
        {"\"channel\": -1", "\"channel\": 12", "set_up: channel: "},
        {"[1.5, 2]", "[1.5, \"2\"]", "set_up: value: "},
        {"[1.5, 2]", "[1.5]", "set_up: value: "},
        {"\"nodes\": [1, 2]", "\"nodes\": [1, 2e40]", "set_up: nodes: "},
        {"\"nodes\": [1, 2]", "\"nodes\": 1", "set_up: nodes: "},
        {"4294967295", "4294967296", "set_up: vehicle_crc32c: "},
        {"\"state\": 2", "\"state\": 4", "set_up: state: "},
        {"\"reason\": 0", "\"reason\": -1", "set_up: reason: "},
        {"\"done\"", "null", "set_up: text: "},
        {"2, -77", "0, -77", "rest: "},
        {"2, -77", "2, 1e300", "rest: "},
        {"1000, 2000", "1000, 9223372036854775807", "over: "}}) {
    std::string text = good;
    const auto at = text.find(one.from);
    ASSERT_NE(at, std::string::npos) << one.from;
    text.replace(at, std::string(one.from).size(), one.to);
    EXPECT_NE(refusal(text).find(one.named), std::string::npos) << one.to << ": " << refusal(text);
  }
}

// The folder of a recording stands beside them.
TEST(SessionState, NoRecordingIsCalledLikeAFileOfTheRecorder) {
  for (const char* own : {"recorder.json", "recorder.json.new", "vehicle", "vehicle.new"})
    EXPECT_NE(fault_of_name(own), "") << own;
  for (const char* free : {"recorder", "vehicles", "my vehicle", "new"})
    EXPECT_EQ(fault_of_name(free), "") << free;
}

TEST(SessionState, ANewRecordingHasANameThatOtherSystemsTake) {
  for (const char* refused : {"con", "CON", "Aux.txt", "com1", "LPT9.old", "x.", "drive\xE2\x80\xAE",
                              "a\xE2\x80\x8B"
                              "b"})
    EXPECT_NE(fault_of_new_name(refused), "") << refused;
  for (const char* free : {"contact", "com", "com10", "console", "x.y",
                           "gr\xC3\xB6\xC3\x9F"
                           "er",
                           "my con"})
    EXPECT_EQ(fault_of_new_name(free), "") << free;
  EXPECT_EQ(fault_of_name("x."), "") << "one that was made before";
}

TEST(SessionState, CapitalsAloneMakeNoOtherName) {
  const test::TemporaryDirectory all;
  std::filesystem::create_directory(all.path() / "Drive 1");
  EXPECT_EQ(taken_by(all.path() / "drive 1", "", {}), "Drive 1");
  EXPECT_EQ(taken_by(all.path() / "DRIVE 1", "", {}), "Drive 1");
  EXPECT_EQ(taken_by(all.path() / "drive 2", "", {}), "");
}

// Where the first disk fails the recording goes on there, beside the other.
TEST(SessionState, CapitalsAloneMakeNoOtherNameInTheFallbackEither) {
  const test::TemporaryDirectory all, fallback;
  std::filesystem::create_directory(fallback.path() / "Drive 1");
  EXPECT_EQ(taken_by(all.path() / "drive 1", fallback.path() / "drive 1", {}), "Drive 1");
  EXPECT_EQ(taken_by(all.path() / "drive 2", fallback.path() / "drive 2", {}), "");
  EXPECT_EQ(taken_by(all.path() / "drive 1", fallback.path() / "none" / "drive 1", {}), "")
      << "made when needed";
}

// The start was refused because of the disk; asked again it must not name a recording that was not made.
TEST(SessionState, AStartThatCameToNothingLeavesItsNameFree) {
  const test::TemporaryDirectory all;
  const auto folder = all.path() / "drive", fallback = all.path() / "fallback";
  EXPECT_EQ(taken_by(folder, "", {}), "");
  std::filesystem::create_directory(folder);
  EXPECT_EQ(taken_by(folder, "", {}), "");
  for (const char* file : {"incarnation", "incarnation.new", "seg-000001.lcm.new"})
    std::ofstream(folder / file) << "7\n";
  EXPECT_EQ(taken_by(folder, fallback, {{"drive 0", 1, 2}}), "");
  EXPECT_NE(taken_by(folder, "", {{"drive", 1, 2}}), "") << "a node may hold a rest of it";
  std::filesystem::create_directory(fallback);
  EXPECT_NE(taken_by(folder, fallback, {}), "") << "it may be recorded there";
}

TEST(SessionState, WhateverElseIsThereTakesAName) {
  for (const char* file : {"seg-000001.lcm", "seg-000001.tail", "continued-in", "notes.txt"}) {
    const test::TemporaryDirectory folder;
    std::ofstream(folder.path() / file) << "";
    EXPECT_NE(taken_by(folder.path(), "", {}), "") << file;
    EXPECT_NE(taken_by(folder.path() / file, "", {}), "") << "a file";
  }
}

}  // namespace
}  // namespace roadbalance
