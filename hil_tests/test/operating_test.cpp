#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <thread>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/results.hpp"
#include "common/config/text_file.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/test/source.hpp"
#include "hil_tests/measurement.hpp"
#include "hil_tests/test/operating_fixture.hpp"
#include "host/recording/recorded_vehicle.hpp"
#include "tools/rb/asking.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using test::Program;
namespace fs = std::filesystem;

TEST_F(Operating, RecordsAgainAndAgainWithoutLosingAnything) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  for (const std::string name : {"one", "two", "three"}) {
    start(name);
    EXPECT_EQ(ask(Operation::kMark, "seen in " + name).state, AnswerState::kDone);
    stop();
    expect_whole(name);
    EXPECT_EQ(count(name, "mark 1: seen in " + name), 1);
  }
  recorder.signal(SIGTERM);
  EXPECT_EQ(recorder.exit_code(30), 0);
}

// Two would answer each request and write one session state.
TEST_F(Operating, OneRecorderToAFolder) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  start("drive");
  const fs::path said = work.path() / "second.said";
  Program second = operated_recorder(said);
  EXPECT_EQ(second.exit_code(30), 4);
  EXPECT_NE(read_text_file(said.string()).find("another rb-recorder"), std::string::npos);
  stop();
  expect_whole("drive");
}

// A recorder that comes back to a vehicle file that was broken meanwhile goes on all the same.
TEST_F(Operating, ABrokenVehicleFileDoesNotEndARecordingUnderWay) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  start("drive");
  recorder.kill();
  const std::string good = test::read_source("sim/demo/vehicle.toml");
  write_vehicle("car.toml", good + "[broken");
  recorder = operated_recorder();
  const Answer mark = ask(Operation::kMark, "here");
  EXPECT_EQ(mark.state, AnswerState::kDone) << mark.text;
  write_vehicle("car.toml", good);
  stop();
  expect_whole("drive");
  const Answer filter = ask(Operation::kFilter, "", {.value = {500, 0}});
  EXPECT_EQ(filter.state, AnswerState::kRefused);
  EXPECT_NE(filter.text.find("car.toml"), std::string::npos) << filter.text;
}

TEST_F(Operating, RefusesASecondStartAndStopsWhatHasHardlyBegun) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  start("first");
  EXPECT_EQ(ask(Operation::kStart, "second").reason, RefusalReason::kRecording);
  EXPECT_EQ(ask(Operation::kStart, "first").reason, RefusalReason::kRecording);
  stop();
  expect_whole("first");
  EXPECT_EQ(ask(Operation::kStart, "first").reason, RefusalReason::kNameTaken);
  // The stop comes before it is known whether the start has reached a node.
  for (int k = 0; k < 5; ++k) {
    const std::string name = "short" + std::to_string(k);
    Request start{.operation = Operation::kStart, .text = name};
    (void)asking.ask(start, milliseconds(30 * k));
    const Answer stopped = ask(Operation::kStop);
    if (stopped.reason == RefusalReason::kNotRecording) continue;  // the start was lost with its asker
    EXPECT_EQ(stopped.state, AnswerState::kDone) << stopped.text;
    if (fs::exists(recordings / name / "seg-000001.lcm")) {
      EXPECT_EQ(verify_record(recordings / name).verdict, Verdict::kComplete) << name;
    }
  }
  start("last");
  stop();
  expect_whole("last");
}

TEST_F(Operating, ARecorderKilledAtAnyRequestLosesNothing) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  std::mt19937 random(7);
  const int turns = test::full_run() ? 30 : 4;
  for (int k = 0; k < turns; ++k) {
    const std::string name = "turn" + std::to_string(k);
    start(name);
    for (const auto operation : {Operation::kMark, Operation::kStop}) {
      Request request{.operation = operation, .text = operation == Operation::kMark ? "here" : ""};
      // Killed between request and answer; the asker goes on asking for the same.
      std::jthread killer([&, after = std::uniform_int_distribution(0, 300)(random)] {
        std::this_thread::sleep_for(milliseconds(after));
        recorder.kill();
        recorder = operated_recorder();
      });
      const auto answer = asking.ask(request, kPatience);
      killer.join();
      ASSERT_TRUE(answer) << asking.silence();
      EXPECT_EQ(answer->state, AnswerState::kDone) << name << ": " << answer->text;
    }
    expect_whole(name);
    EXPECT_GE(count(name, "mark 1: here"), 1);  // noted again if it was not known to be on the disk
    EXPECT_EQ(count(name, "mark 2: here"), 0);
  }
}

TEST_F(Operating, ANodeKilledWhileItMeasuresIsDeclaredAndTheRecordingGoesOn) {
  Program recorder = operated_recorder(), front = staying("front");
  {
    Program rear = staying("rear");
    start("killed");
    ASSERT_TRUE(more_are_durable(kRear, 20));
    rear.kill();
  }
  const std::int64_t killed = bus.heartbeat(kRear).epoch;
  Program rear = staying("rear");
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kRear).epoch != killed; }));
  ASSERT_TRUE(more_are_durable(kRear, 20));
  ASSERT_EQ(ask(Operation::kStop).state, AnswerState::kDone);
  const auto receipts = asking.receipts(kPatience);
  ASSERT_EQ(receipts.size(), 2u);
  EXPECT_EQ(receipts.at(1).epochs, 2);
  EXPECT_EQ(verify_record(recordings / "killed").verdict, Verdict::kIncomplete);
}

TEST_F(Operating, ARangeIsInForceAtTheNodeAndInTheNextRecord) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  start("before");
  Request range{.node = kRear, .channel = 4, .value = {80, 0}};
  const Answer busy = ask(Operation::kRange, "", range);
  EXPECT_EQ(busy.reason, RefusalReason::kRecording) << "one set-up from the first sample to the last";
  stop();
  const Answer done = ask(Operation::kRange, "", range);
  EXPECT_EQ(done.state, AnswerState::kDone) << done.text;
  const Answer filtered = ask(Operation::kFilter, "", {.value = {150, 4}});
  EXPECT_EQ(filtered.state, AnswerState::kDone) << filtered.text;
  start("after");
  stop();
  expect_whole("after");
  const auto before = recorded_vehicle(recordings / "before"), after = recorded_vehicle(recordings / "after");
  ASSERT_TRUE(before && after);
  EXPECT_EQ(before->node[1].channel[4].range_m_s2, 50);
  EXPECT_EQ(after->node[1].channel[4].range_m_s2, 80);
  EXPECT_EQ(after->filter.cutoff_hz, 150);
  EXPECT_EQ(after->filter.order, 4);
  EXPECT_EQ(VehicleConfig::read_file((vehicles / "car.toml").string()).node[1].channel[4].range_m_s2, 80);
}

// Asked for at once behind a stop, and a start at once behind that.
TEST_F(Operating, ASetUpBetweenTwoRecordingsWithoutAPauseLosesNothing) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  for (int k = 0; k < 4; ++k) {
    const std::string name = "part" + std::to_string(k);
    start(name);
    stop();
    Answer done;
    ASSERT_TRUE(test::wait_until(
        [&] {
          done = ask(Operation::kRange, "", {.node = kFront, .channel = 0, .value = {100.0 + k, 0}});
          return done.reason != RefusalReason::kNoNode;  // between two epochs it is not there
        },
        60));
    EXPECT_EQ(done.state, AnswerState::kDone) << done.text;
    expect_whole(name);
  }
  start("last");
  stop();
  EXPECT_EQ(recorded_vehicle(recordings / "last")->node[0].channel[0].range_m_s2, 103);
}

TEST_F(Operating, RefusesASetUpThatCannotBeAndLeavesTheOneThatIs) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  start("car");
  stop();
  const std::string before = test::read_source("sim/demo/vehicle.toml");
  EXPECT_EQ(ask(Operation::kRange, "", {.node = 7, .channel = 0, .value = {80, 0}}).reason,
            RefusalReason::kNoNode);
  EXPECT_EQ(ask(Operation::kRange, "", {.node = kRear, .channel = 0, .value = {-1, 0}}).reason,
            RefusalReason::kBadArgument);
  EXPECT_EQ(ask(Operation::kFilter, "", {.value = {5000, 0}}).state, AnswerState::kRefused);
  const Answer zero = ask(Operation::kZero);
  EXPECT_EQ(zero.reason, RefusalReason::kMoving) << zero.text;  // the simulated car drives
  EXPECT_EQ(ask(Operation::kVehicle, "../../etc/passwd").reason, RefusalReason::kBadArgument);
  const Answer unknown = ask(Operation::kVehicle, "no.toml");
  EXPECT_EQ(unknown.reason, RefusalReason::kBadArgument);
  EXPECT_NE(unknown.text.find("car.toml"), std::string::npos) << "it says which there are: " << unknown.text;
  write_vehicle("bad.toml", "name = 3\n");
  EXPECT_EQ(ask(Operation::kVehicle, "bad.toml").reason, RefusalReason::kBadArgument);
  // A file that one node cannot measure by: the other gets the old one back.
  write_vehicle("other.toml", test::replaced(before, "name = \"rear\"\nid = 2", "name = \"rear\"\nid = 5"));
  const Answer other = ask(Operation::kVehicle, "other.toml");
  EXPECT_EQ(other.reason, RefusalReason::kNotSupported) << other.text;
  EXPECT_NE(other.text.find("id"), std::string::npos) << other.text;
  start("after");
  stop();
  const auto vehicle = recorded_vehicle(recordings / "after");
  ASSERT_TRUE(vehicle);
  EXPECT_EQ(vehicle->text, before);
}

// On a flat road at no speed channels read their noise, whose mean is nothing but the converter's offset.
TEST_F(Operating, ZerosAreTheReadingsOfACarThatStands) {
  std::string scenario = test::read_source("sim/demo/scenario.toml");
  for (const char* speed : {"90.0", "103.0", "117.0", "130.0"})
    scenario = test::replaced(scenario, std::string("speed_km_h = ") + speed, "speed_km_h = 0.0");
  scenario = test::replaced(scenario, "wander_km_h = 0.5", "wander_km_h = 0.0");
  const fs::path file = work.path() / "standing.toml";
  std::ofstream(file) << scenario;
  Program recorder = operated_recorder(), front = staying("front", file.string()),
          rear = staying("rear", file.string());
  Answer zero;
  // At first too little has been heard.
  ASSERT_TRUE(test::wait_until(
      [&] {
        zero = ask(Operation::kZero);
        return zero.state == AnswerState::kDone;
      },
      30))
      << zero.text;
  start("zeroed");
  ASSERT_TRUE(more_are_durable(kFront, 5) && more_are_durable(kRear, 5));
  stop();
  const auto vehicle = recorded_vehicle(recordings / "zeroed");
  ASSERT_TRUE(vehicle);
  int read = 0, channels = 0;
  for (const NodeConfig& node : vehicle->node)
    for (const ChannelConfig& channel : node.channel) {
      ++channels;
      read += channel.offset_counts != 0;  // to a tenth of a count, which a mean may well be by chance
      EXPECT_LT(std::abs(channel.offset_counts * channel.scale_m_s2_per_count), 0.1) << channel.name;
    }
  EXPECT_GT(read, channels / 2);
}

// A person who sets up a car looks at levels before anything is recorded.
TEST_F(Operating, ThereAreLevelsBeforeTheFirstRecordingAndBehindIt) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  const Program analyser("rb-analyser", {"--url", url, "--recordings", recordings.string(), "--vehicle",
                                         (vehicles / "car.toml").string()});
  Bus ear(url);
  std::map<std::int32_t, int> levels;
  ear.subscribe(kLevelChannel, [&](std::string_view, auto bytes) {
    if (const auto level = decode_level(bytes)) ++levels[level->node];
  });
  const auto both_are_heard = [&] {
    levels.clear();
    return test::wait_until(
        [&] {
          ear.handle(milliseconds(20));
          return levels[kFront] > 5 && levels[kRear] > 5;
        },
        60);
  };
  EXPECT_TRUE(both_are_heard());
  EXPECT_FALSE(fs::exists(recordings / "drive"));
  start("drive");
  EXPECT_TRUE(both_are_heard());
  stop();
  EXPECT_TRUE(both_are_heard());
}

TEST_F(Operating, ChoosesAVehicleFileByItsName) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  write_vehicle("winter.toml", test::replaced(test::read_source("sim/demo/vehicle.toml"),
                                              "name = \"demonstration car\"", "name = \"winter tyres\""));
  start("summer");
  EXPECT_EQ(ask(Operation::kVehicle, "winter.toml").reason, RefusalReason::kRecording);
  stop();
  const Answer done = ask(Operation::kVehicle, "winter.toml");
  EXPECT_EQ(done.state, AnswerState::kDone) << done.text;
  start("winter");
  stop();
  expect_whole("winter");
  EXPECT_EQ(recorded_vehicle(recordings / "summer")->name, "demonstration car");
  EXPECT_EQ(recorded_vehicle(recordings / "winter")->name, "winter tyres");
}

}  // namespace
}  // namespace roadbalance
