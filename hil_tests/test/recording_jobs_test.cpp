#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <array>
#include <chrono>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/job.hpp"
#include "common/bus/recording.hpp"
#include "common/test/bus_url.hpp"
#include "common/test/temporary_directory.hpp"
#include "hil_tests/private_mounts.hpp"
#include "hil_tests/program.hpp"
#include "hil_tests/recording_digests.hpp"
#include "host/recorder/verify.hpp"
#include "tools/rb/asking.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;
using test::Program;

constexpr double kPatience_s = 120;

/// The real rb-recordings with a real recording; who asks is on the bus, as the page's rb-web is.
class RecordingJobs : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    ASSERT_EQ(test::run("rb",
                        {"demo", "--headless", "--rate", "max", "--drive-seconds", "80", "--seed", "1",
                         "--record", drive().string()},
                        kPatience_s),
              0);
    // As if it had ended a while ago: nothing waits for it to be quiet.
    for (const auto& file : fs::directory_iterator(drive()))
      fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(1));
  }
  static void TearDownTestSuite() { fs::remove_all(drives()); }
  static fs::path drives() {
    static const fs::path folder = fs::temp_directory_path() / ("rb-jobs-" + std::to_string(getpid()));
    fs::create_directories(folder);
    return folder;
  }
  static fs::path drive() { return drives() / "drive"; }

  RecordingJobs() {
    fs::create_directories(disk);
    bus.subscribe(kJobChannel, [this](std::string_view, auto bytes) {
      if (auto job = decode_job(bytes); job && job->jobs > 0) told[job->place] = *job;
    });
  }
  void TearDown() override { EXPECT_EQ(test::digests_of(drive()), before) << "the source is as it was"; }

  Program recordings() const {
    return Program("rb-recordings", {"--url", url, "--folder", drives().string(), "--results",
                                     results.string(), "--transfer-to", disk.string()});
  }
  Answer ask(Operation operation, double value, const std::string& text = "") {
    Asking asking(url);
    Answer answer;
    // Until it is there and knows of the recording.
    test::wait_until(
        [&] {
          answer =
              asking
                  .ask({.operation = operation, .value = {value, 0}, .text = text}, std::chrono::seconds(10))
                  .value_or(Answer{});
          return answer.state == AnswerState::kDone || answer.reason != RefusalReason::kNone;
        },
        kPatience_s);
    return answer;
  }
  void begin(JobKind kind, const std::string& options = "") {
    previous = newest().job;
    const Answer answer = ask(Operation::kJob, static_cast<double>(kind), "drive" + options);
    ASSERT_EQ(answer.state, AnswerState::kDone) << answer.text;
  }
  Job newest() const {
    Job newest;
    for (const auto& [place, job] : told)
      if (job.job > newest.job) newest = job;
    return newest;
  }
  Job until_ended() {
    EXPECT_TRUE(test::wait_until(
        [&] {
          bus.handle(std::chrono::milliseconds(20));
          return newest().job > previous && newest().state > JobState::kHeld;
        },
        kPatience_s));
    return newest();
  }
  /// Waits until this file or folder is being made, and holds the command that makes it.
  void hold_in_the_middle(const Program& program, const fs::path& half) const {
    ASSERT_TRUE(test::wait_until([&] { return fs::exists(half); }, kPatience_s)) << half;
    for (const auto& thread : fs::directory_iterator("/proc/" + std::to_string(program.pid()) + "/task")) {
      std::ifstream children(thread.path() / "children");
      for (pid_t child = 0; children >> child;) kill(child, SIGSTOP);
    }
    ASSERT_TRUE(fs::exists(half)) << "it was too fast to be held";
  }

  const test::TemporaryDirectory work;
  const fs::path results = work.path() / "results", disk = work.path() / "disk";
  const std::string url = test::bus_url();
  Bus bus{url};
  std::map<std::int32_t, Job> told;
  std::int64_t previous = 0;  ///< job before the one that was begun last
  const std::map<std::string, std::string> before = test::digests_of(drive());
};

struct Asked {
  JobKind kind;
  const char *options, *result;
};
constexpr std::array kMade{Asked{JobKind::kExport, "/format=uff58", "drive.uff"},
                           Asked{JobKind::kSelect, "/from=1", "drive-selected"},
                           Asked{JobKind::kReduce, "/rate=500", "drive-reduced-500Hz"}};

// Each would end what the other makes.
TEST_F(RecordingJobs, OneProgramToAFolderOfResults) {
  const Program running = recordings();
  ASSERT_TRUE(test::wait_until([&] { return fs::exists(results); }, kPatience_s));
  begin(JobKind::kVerify);  // it is there
  EXPECT_EQ(until_ended().state, JobState::kDone);
  Program second = recordings();
  EXPECT_EQ(second.exit_code(kPatience_s), 4);
}

TEST_F(RecordingJobs, CopiesGoElsewhere) {
  for (const fs::path& place : {drives(), results}) {
    Program refused("rb-recordings", {"--url", url, "--folder", drives().string(), "--results",
                                      results.string(), "--transfer-to", place.string()});
    EXPECT_EQ(refused.exit_code(kPatience_s), 4) << place;
  }
}

TEST_F(RecordingJobs, EveryFormatOfThePageIsMade) {
  const Program running = recordings();
  for (const auto& [format, file] : std::map<std::string, std::string>{{"mdf4", "drive.mf4"},
                                                                       {"hdf5", "drive.h5"},
                                                                       {"mat", "drive.mat"},
                                                                       {"uff58", "drive.uff"},
                                                                       {"wav", "drive.wav"},
                                                                       {"csv", "drive.csv"},
                                                                       {"mcap", "drive.mcap"}}) {
    begin(JobKind::kExport, "/format=" + format + "/from=2/to=3");
    const Job job = until_ended();
    EXPECT_EQ(job.state, JobState::kDone) << format << ": " << job.text;
    EXPECT_TRUE(job.text.starts_with((results / file).string() + ", ")) << job.text;
    EXPECT_GT(fs::file_size(results / file), 10'000U);
    EXPECT_EQ(job.progress, 1);
  }
}

TEST_F(RecordingJobs, MakesRecordingsThatAreComplete) {
  const Program running = recordings();
  for (const Asked& asked : {kMade[1], kMade[2]}) {
    begin(asked.kind, asked.options);
    EXPECT_EQ(until_ended().state, JobState::kDone) << newest().text;
    EXPECT_EQ(verify_record(results / asked.result).verdict, Verdict::kComplete);
  }
}

// What the page offers is what rb takes: one definition, on both sides of the bus.
TEST_F(RecordingJobs, IsReducedAsFarAsTheListSaysAndNoFurther) {
  RecordingReceipt listed;
  bus.subscribe(kRecordingChannel, [&](std::string_view, auto bytes) {
    if (const auto receipt = decode_recording(bytes); receipt && receipt->name == "drive") listed = *receipt;
  });
  const Program running = recordings();
  ASSERT_TRUE(test::wait_until(
      [&] {
        bus.handle(std::chrono::milliseconds(20));
        return listed.most_reduction > 0;
      },
      kPatience_s));
  EXPECT_EQ(listed.rate_hz, 2000);
  EXPECT_EQ(listed.cutoff_hz, 200);
  const auto reduce = [&](int factor) {
    return test::run("rb",
                     {"reduce", drive().string(), "--factor", std::to_string(factor), "--output",
                      (work.path() / std::to_string(factor)).string()},
                     kPatience_s);
  };
  EXPECT_EQ(reduce(listed.most_reduction), 0);
  EXPECT_EQ(reduce(listed.most_reduction + 1), 2);
}

TEST_F(RecordingJobs, KilledInTheMiddleIsToldAsInterruptedLeavesNothingHalfAndBeginsAnew) {
  for (const Asked& asked : kMade) {
    const fs::path result = results / asked.result, half = result.string() + ".part";
    Program running = recordings();
    begin(asked.kind, asked.options);
    hold_in_the_middle(running, half);
    running.kill();
    running = recordings();
    const Job job = until_ended();
    EXPECT_EQ(job.state, JobState::kInterrupted) << job.text;
    EXPECT_NE(job.text.find("begins anew"), std::string::npos) << job.text;
    EXPECT_TRUE(test::wait_until([&] { return !fs::exists(half); }, kPatience_s)) << half;
    EXPECT_FALSE(fs::exists(result));
    begin(asked.kind, asked.options);
    EXPECT_EQ(until_ended().state, JobState::kDone) << newest().text;
    EXPECT_TRUE(fs::exists(result));
  }
}

TEST_F(RecordingJobs, CancelledInTheMiddleLeavesNothingHalf) {
  const Program running = recordings();
  for (const Asked& asked : kMade) {
    const fs::path result = results / asked.result, half = result.string() + ".part";
    begin(asked.kind, asked.options);
    hold_in_the_middle(running, half);
    ASSERT_TRUE(test::wait_until(
        [&] {
          bus.handle(std::chrono::milliseconds(20));
          return newest().job > previous;
        },
        kPatience_s));
    EXPECT_EQ(ask(Operation::kCancel, static_cast<double>(newest().job)).state, AnswerState::kDone);
    EXPECT_EQ(until_ended().state, JobState::kCancelled) << newest().text;
    EXPECT_FALSE(fs::exists(half));
    EXPECT_FALSE(fs::exists(result));
  }
}

TEST_F(RecordingJobs, ATransferThatWasKilledOrCancelledGoesOnWhereItWas) {
  const fs::path half = disk / "drive.part";
  Program running = recordings();
  begin(JobKind::kTransfer);
  hold_in_the_middle(running, half);
  running.kill();
  told.clear();
  running = recordings();
  EXPECT_EQ(until_ended().state, JobState::kInterrupted);
  EXPECT_TRUE(fs::exists(half));
  EXPECT_FALSE(fs::exists(disk / "drive"));
  begin(JobKind::kTransfer);
  const Job job = until_ended();
  EXPECT_EQ(job.state, JobState::kDone) << job.text;
  EXPECT_NE(job.text.find("read back and equal"), std::string::npos) << job.text;
  EXPECT_EQ(test::digests_of(disk / "drive", "sha256.txt"), before);
}

TEST_F(RecordingJobs, AFullDiskIsNamedAndNothingHalfIsLeft) {
  if (const auto obstacle = test::enter_private_mounts()) GTEST_SKIP() << *obstacle;
  const test::MemoryDisk small(results, 8 << 20);
  const Program running = recordings();
  // Of a file of text only the least is known beforehand, and that is room for here.
  const fs::path result = results / "drive.csv";
  begin(JobKind::kExport, "/format=csv");
  const Job job = until_ended();
  EXPECT_EQ(job.state, JobState::kFailed);
  EXPECT_NE(job.text.find(result.string()), std::string::npos) << job.text;
  EXPECT_NE(job.text.find("No space left on device: make room"), std::string::npos) << job.text;
  EXPECT_FALSE(fs::exists(result.string() + ".part"));
  EXPECT_FALSE(fs::exists(result));
}

TEST_F(RecordingJobs, WhatSurelyDoesNotFitIsRefusedBeforeItBeginsWithBothFigures) {
  if (const auto obstacle = test::enter_private_mounts()) GTEST_SKIP() << *obstacle;
  const test::MemoryDisk small(results, 2 << 20), copies(disk, 2 << 20);
  const Program running = recordings();
  for (const Asked& asked : kMade) {
    begin(asked.kind, asked.options);
    const Job job = until_ended();
    EXPECT_EQ(job.state, JobState::kFailed);
    EXPECT_THAT(job.text,
                testing::MatchesRegex(results.string() +
                                      ": at least [0-9]+.[0-9] MB are to go there, "
                                      "2.[01] MB are free: make room on its disk, and begin again"));
    EXPECT_FALSE(fs::exists((results / asked.result).string() + ".part"));
    EXPECT_FALSE(fs::exists(results / asked.result));
  }
  begin(JobKind::kTransfer);
  EXPECT_EQ(until_ended().state, JobState::kFailed);
  EXPECT_THAT(newest().text,
              testing::MatchesRegex(disk.string() +
                                    ": at least [0-9]+.[0-9] MB are to go there, 2.[01] MB are free.*"));
}

// The bound is honest: where there is room for what is made, and little more, it is made.
TEST_F(RecordingJobs, WhatJustFitsIsNotRefused) {
  if (const auto obstacle = test::enter_private_mounts()) GTEST_SKIP() << *obstacle;
  const auto make = [&](std::vector<std::string> words, const fs::path& to) {
    words.insert(words.begin() + 1, drive().string());
    words.insert(words.end(), {"--output", to.string()});
    if (words[2] == "--format=candump") words.push_back("--dbc=" + (work.path() / "frames.dbc").string());
    EXPECT_EQ(test::run("rb", words, kPatience_s), 0) << words[0] << " " << words[2];
  };
  const auto bytes_of = [](const fs::path& made) {
    std::uintmax_t bytes = 0;
    if (fs::is_regular_file(made)) return fs::file_size(made);
    for (const auto& file : fs::directory_iterator(made)) bytes += file.file_size();
    return bytes;
  };
  std::vector<std::vector<std::string>> all{{"select", "--from=2", "--to=12"}, {"reduce", "--factor=2"}};
  for (const char* const format : {"candump", "csv", "hdf5", "mat", "mcap", "mdf4", "uff58", "wav"})
    all.push_back({"export", "--format=" + std::string(format), "--from=2", "--to=12"});
  for (const auto& words : all) {
    const fs::path large = work.path() / "large";
    make(words, large);
    constexpr std::uintmax_t kMore = 300'000;  // pages, folders, and what a recording reserves
    const std::uintmax_t bytes = bytes_of(large) + kMore;
    fs::remove_all(large);
    fs::remove(work.path() / "frames.dbc");
    const fs::path place = work.path() / "small";
    fs::create_directories(place);
    const test::MemoryDisk disk_of_it(place, bytes);
    make(words, place / "made");
    fs::remove(work.path() / "frames.dbc");
  }
}

TEST_F(RecordingJobs, ADiskThatIsNotThereIsNamed) {
  fs::remove(disk);
  const Program running = recordings();
  begin(JobKind::kTransfer);
  EXPECT_EQ(until_ended().state, JobState::kFailed);
  EXPECT_NE(newest().text.find(disk.string() + ": there is no such folder to take it to"), std::string::npos)
      << newest().text;
}

}  // namespace
}  // namespace roadbalance
