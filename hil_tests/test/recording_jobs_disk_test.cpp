#include <gmock/gmock.h>

#include "hil_tests/private_mounts.hpp"
#include "hil_tests/test/recording_jobs_fixture.hpp"

namespace roadbalance {
namespace {

TEST_F(RecordingJobs, AFullDiskIsNamedAndNothingHalfIsLeft) {
  if (const auto refusal = test::enter_private_mounts()) GTEST_SKIP() << *refusal;
  const test::MemoryDisk small(results, 8 << 20);
  const Program running = recordings();
  // Only the least size of a text file is known beforehand, and there is room for that here.
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
  if (const auto refusal = test::enter_private_mounts()) GTEST_SKIP() << *refusal;
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
  if (const auto refusal = test::enter_private_mounts()) GTEST_SKIP() << *refusal;
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
