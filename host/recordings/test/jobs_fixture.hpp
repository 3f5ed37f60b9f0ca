#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "common/test/temporary_directory.hpp"
#include "host/recordings/jobs.hpp"

namespace roadbalance {

namespace fs = std::filesystem;

/// Stands for rb: a real program, whose script a test chooses.
class JobsTest : public testing::Test {
 protected:
  void rb_does(const std::string& script) {
    std::ofstream(rb) << "#!/bin/sh\n" << script << "\n";
    fs::permissions(rb, fs::perms::owner_all);
  }
  Answer ask(JobKind kind, const std::string& recording, bool grows = false) {
    return ask_by({.asker = 1,
                   .request = ++requests,
                   .operation = Operation::kJob,
                   .value = {static_cast<double>(kind), 0},
                   .text = recording},
                  grows);
  }
  Answer ask_by(const Request& request, bool grows = false) {
    const auto answer = jobs.take(request, known, grows, at(++utc_us));
    EXPECT_TRUE(answer);
    return answer.value_or(Answer{});
  }
  Answer cancel(std::int64_t job) {
    return ask_by({.asker = 1,
                   .request = ++requests,
                   .operation = Operation::kCancel,
                   .value = {static_cast<double>(job), 0}});
  }
  /// The newest job, once it is in this state.
  Job until(JobState state, bool grows = false) {
    for (int k = 0; k < 12'000; ++k) {
      jobs.turn(grows, at(utc_us += 10'000));
      if (newest().state == state) return newest();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << "job has state " << static_cast<int>(newest().state) << ": " << newest().text;
    return newest();
  }
  static JobInstant at(std::int64_t us) { return {us, WallTime(std::chrono::microseconds(us))}; }
  Job newest() const { return std::ranges::max(jobs.reported(), {}, &Job::job); }

  test::TemporaryDirectory folder;
  const fs::path rb = folder.path() / "rb";
  std::vector<ListedRecording> known{
      {{.name = "second", .vehicle = "", .bytes = 1000}, folder.path() / "second"},
      {{.name = "first", .vehicle = "", .bytes = 1000}, folder.path() / "first"}};
  const fs::path results = folder.path() / "results", disk = folder.path() / "disk";
  const JobPlaces places{results, disk};
  Jobs jobs{rb, places};
  std::int64_t utc_us = 1'000'000, requests = 0;
};

inline std::string joined(const std::vector<DocumentPart>& parts, std::int64_t job) {
  std::string document;
  std::int32_t next = 0;
  for (const auto& part : parts)
    if (part.job == job && part.part == next) document += part.bytes, ++next;
  return document;
}

}  // namespace roadbalance
