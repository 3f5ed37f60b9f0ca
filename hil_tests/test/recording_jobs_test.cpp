#include "common/bus/recording.hpp"
#include "hil_tests/test/recording_jobs_fixture.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {
namespace {

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
                                                                       {"mcap", "drive.mcap"},
                                                                       {"candump", "drive.log"}}) {
    begin(JobKind::kExport, "/format=" + format + "/from=2/to=3");
    const Job job = until_ended();
    EXPECT_EQ(job.state, JobState::kDone) << format << ": " << job.text;
    EXPECT_TRUE(job.text.starts_with((results / file).string() + ", ")) << job.text;
    EXPECT_GT(fs::file_size(results / file), 10'000U);
    EXPECT_EQ(job.progress, 1);
  }
  EXPECT_GT(fs::file_size(results / "drive.dbc"), 1000U) << "without it nobody can tell the log's frames";
}

TEST_F(RecordingJobs, MakesRecordingsThatAreComplete) {
  const Program running = recordings();
  for (const Asked& asked : {kMade[1], kMade[2]}) {
    begin(asked.kind, asked.options);
    EXPECT_EQ(until_ended().state, JobState::kDone) << newest().text;
    EXPECT_EQ(verify_record(results / asked.result).verdict, Verdict::kComplete);
  }
}

// The page offers exactly the values that rb takes: one definition, on both sides of the bus.
TEST_F(RecordingJobs, IsReducedAsFarAsTheListSaysAndNoFurther) {
  RecordingSummary listed;
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

}  // namespace
}  // namespace roadbalance
