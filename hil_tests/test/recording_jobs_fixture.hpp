#pragma once

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
#include "common/test/bus_url.hpp"
#include "common/test/temporary_directory.hpp"
#include "hil_tests/program.hpp"
#include "hil_tests/recording_digests.hpp"
#include "tools/rb/asking.hpp"

namespace roadbalance {

namespace fs = std::filesystem;
using test::Program;

inline constexpr double kPatience_s = 120;

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
    // Until it runs and lists the recording.
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
inline constexpr std::array kMade{Asked{JobKind::kExport, "/format=uff58", "drive.uff"},
                                  Asked{JobKind::kSelect, "/from=1", "drive-selected"},
                                  Asked{JobKind::kReduce, "/rate=500", "drive-reduced-500Hz"}};

}  // namespace roadbalance
