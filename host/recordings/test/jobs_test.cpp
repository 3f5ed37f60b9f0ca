#include "host/recordings/test/jobs_fixture.hpp"

namespace roadbalance {
namespace {

TEST_F(JobsTest, ToldBeforeTheFirstSaysThatThereIsNone) {
  const auto reported = jobs.reported();
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_EQ(reported[0].jobs, 0);
  EXPECT_TRUE(jobs.due_parts().empty());
}

TEST_F(JobsTest, RunsTheCommandOnTheRecordingAndShowsWhatItSays) {
  rb_does("echo \"$@\"; echo complete");
  EXPECT_EQ(ask(JobKind::kVerify, "first").state, AnswerState::kDone);
  const Job job = until(JobState::kDone);
  EXPECT_EQ(job.recording, "first");
  EXPECT_EQ(job.progress, 1);
  EXPECT_EQ(job.document_kind, DocumentKind::kText);
  EXPECT_EQ(joined(jobs.due_parts(), job.job),
            "verify " + (folder.path() / "first").string() + "\ncomplete\n");
}

TEST_F(JobsTest, MakesAReportOfTwoDrivesAsAPage) {
  rb_does("[ \"$3 $5\" = '--before --output' ] && echo \"<p>$2 $4\" > \"$6\"");
  EXPECT_EQ(ask(JobKind::kReport, "second/before=first").state, AnswerState::kDone);
  const Job job = until(JobState::kDone);
  EXPECT_EQ(job.options, "before=first");
  EXPECT_EQ(job.document_kind, DocumentKind::kPage);
  EXPECT_EQ(joined(jobs.due_parts(), job.job),
            "<p>" + (folder.path() / "second").string() + " " + (folder.path() / "first").string() + "\n");
}

TEST_F(JobsTest, SaysWhatIsBadAndWhatCouldNotBeDone) {
  rb_does("echo 'samples are missing'; exit 3");
  ask(JobKind::kVerify, "first");
  const Job job = until(JobState::kNotWell);
  EXPECT_EQ(joined(jobs.due_parts(), job.job), "samples are missing\n");
  rb_does("echo 'rb: first: cannot be read' >&2; exit 4");
  ask(JobKind::kVerify, "first");
  EXPECT_EQ(until(JobState::kFailed).text, "first: cannot be read");
}

TEST_F(JobsTest, SaysInOurWordsHowACommandWasEnded) {
  const auto failure = [&](const std::string& script) {
    rb_does(script);
    ask(JobKind::kSelect, "first");
    return until(JobState::kFailed).text;
  };
  EXPECT_TRUE(failure("kill -KILL $$").starts_with("rb select was ended from outside")) << newest().text;
  EXPECT_NE(newest().text.find("begun again it begins anew"), std::string::npos) << newest().text;
  EXPECT_TRUE(failure("kill -TERM $$").starts_with("rb select was told to end, not by rb-recordings"));
  EXPECT_TRUE(
      failure("kill -SEGV $$").starts_with("rb select broke off (signal 11), which is a fault of the"));
  EXPECT_TRUE(failure("exit 127").starts_with("rb select cannot be run"));
  EXPECT_EQ(failure("exit 4"), "it said nothing");
}

TEST_F(JobsTest, LastsByAClockThatNobodySteps) {
  rb_does("exec sleep 60");
  constexpr std::int64_t kDay_us = 86'400'000'000;
  const auto instant = [](std::int64_t us, std::int64_t steady_s) {
    return JobInstant{us, WallTime(std::chrono::seconds(steady_s))};
  };
  const Request asked{
      .asker = 1, .request = 98, .operation = Operation::kJob, .value = {1, 0}, .text = "first"};
  ASSERT_EQ(jobs.take(asked, known, false, instant(2 * kDay_us, 100))->state, AnswerState::kDone);
  jobs.turn(false, instant(kDay_us, 107));  // the clock was set
  const Job first = newest();
  EXPECT_EQ(first.began_us, 2 * kDay_us);
  EXPECT_EQ(first.elapsed_s, 7);
  EXPECT_EQ(cancel(first.job).state, AnswerState::kDone);
  until(JobState::kCancelled);
  Request again = asked;
  again.request = 99;
  ASSERT_EQ(jobs.take(again, known, false, instant(kDay_us, 200))->state, AnswerState::kDone);
  EXPECT_GT(newest().job, first.job) << "the newer is told as the newer";
  EXPECT_EQ(newest().began_us, kDay_us) << "and when it began as people tell it";
}

TEST_F(JobsTest, RefusesWhatCannotBeAndSaysWhy) {
  rb_does("sleep 60");
  EXPECT_EQ(ask(JobKind::kVerify, "third").reason, RefusalReason::kBadArgument);
  EXPECT_EQ(ask(JobKind::kVerify, "").reason, RefusalReason::kBadArgument);
  EXPECT_EQ(ask(JobKind::kVerify, "../etc").reason, RefusalReason::kBadArgument);
  EXPECT_EQ(ask(JobKind::kReport, "second/before=third").reason, RefusalReason::kBadArgument);
  EXPECT_EQ(ask(JobKind::kVerify, "second/before=first").reason, RefusalReason::kBadArgument);
  EXPECT_EQ(ask(JobKind::kReport, "first/before=first").reason, RefusalReason::kBadArgument);
  EXPECT_EQ(ask(static_cast<JobKind>(99), "first").reason, RefusalReason::kNotSupported);
  EXPECT_EQ(ask(JobKind::kVerify, "first", true).reason, RefusalReason::kRecording);
  EXPECT_EQ(ask(JobKind::kVerify, "first").state, AnswerState::kDone);
  const Answer busy = ask(JobKind::kVerify, "second");
  EXPECT_EQ(busy.reason, RefusalReason::kBusy);
  EXPECT_NE(busy.text.find("\"first\" is being worked on"), std::string::npos) << busy.text;
  EXPECT_FALSE(
      jobs.take({.asker = 1, .request = 99, .operation = Operation::kStop}, known, false, at(utc_us)));
}

TEST_F(JobsTest, WithoutTheProgramARequestIsRefused) {
  const Answer answer = ask(JobKind::kVerify, "first");
  EXPECT_EQ(answer.reason, RefusalReason::kNotSupported);
  EXPECT_NE(answer.text.find(rb.string()), std::string::npos) << answer.text;
}

TEST_F(JobsTest, ARepeatedRequestActsOnceAndIsAnsweredAlike) {
  rb_does("echo once >> " + (folder.path() / "log").string());
  const Request request{
      .asker = 1, .request = 7, .operation = Operation::kJob, .value = {1, 0}, .text = "first"};
  EXPECT_EQ(ask_by(request).state, AnswerState::kDone);
  until(JobState::kDone);
  EXPECT_EQ(ask_by(request).state, AnswerState::kDone);
  EXPECT_EQ(jobs.reported().size(), 1U);
  std::ifstream log(folder.path() / "log");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(log), {}), "once\n");
}

TEST_F(JobsTest, CancelEndsItAndLetsAnotherBegin) {
  rb_does("exec sleep 60");
  ask(JobKind::kVerify, "first");
  const std::int64_t job = newest().job;
  EXPECT_EQ(cancel(job + 1).state, AnswerState::kRefused);
  EXPECT_EQ(cancel(job).state, AnswerState::kDone);
  EXPECT_EQ(until(JobState::kCancelled).job, job);
  EXPECT_EQ(cancel(job).state, AnswerState::kRefused);
  rb_does("echo done");
  EXPECT_EQ(ask(JobKind::kVerify, "second").state, AnswerState::kDone);
  until(JobState::kDone);
  EXPECT_EQ(jobs.reported().size(), 2U);
}

TEST_F(JobsTest, ADeafProgramIsEndedAfterAWhile) {
  const fs::path deaf = folder.path() / "deaf";
  rb_does("trap '' TERM; touch " + deaf.string() + "; while :; do sleep 0.1; done");
  ask(JobKind::kVerify, "first");
  for (int k = 0; k < 12'000 && !fs::exists(deaf); ++k) {
    jobs.turn(false, at(utc_us += 10'000));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_TRUE(fs::exists(deaf));
  cancel(newest().job);
  until(JobState::kCancelled);
}

TEST_F(JobsTest, IsHeldWhileARecordingIsUnderWay) {
  const fs::path go = folder.path() / "go";
  rb_does("while [ ! -e " + go.string() + " ]; do sleep 0.01; done; echo done");
  ask(JobKind::kVerify, "first");
  until(JobState::kHeld, true);
  std::ofstream(go) << "";
  // A held process cannot notice that it should end.
  for (int k = 0; k < 40; ++k) {
    jobs.turn(true, at(utc_us += 10'000));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(newest().state, JobState::kHeld);
  EXPECT_EQ(until(JobState::kDone).progress, 1);
}

TEST_F(JobsTest, AHeldJobCanBeCancelled) {
  rb_does("exec sleep 60");
  ask(JobKind::kVerify, "first");
  until(JobState::kHeld, true);
  cancel(newest().job);
  until(JobState::kCancelled, true);
}

TEST_F(JobsTest, ProgressIsTheShareOfWhatIsReadAlready) {
  const fs::path data = folder.path() / "data";
  constexpr std::int64_t kBytes = 50'000'000;
  std::ofstream(data) << std::string(kBytes / 2, 'x');
  known[0].summary.bytes = kBytes;
  // Reads half of the recording, then waits: in one process, since the counters belong to a process.
  rb_does("exec perl -e 'open(F, \"" + data.string() + "\"); while (sysread(F, $x, 1000000)) {} sleep 60'");
  ask(JobKind::kVerify, "second");
  for (int k = 0; k < 12'000 && newest().progress < 0.5; ++k) {
    jobs.turn(false, at(utc_us += 10'000));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_NEAR(newest().progress, 0.5, 0.01) << "what perl itself reads to begin with is the rest";
  cancel(newest().job);
  until(JobState::kCancelled);
}

TEST_F(JobsTest, ATextThatIsTooLongIsCutAndSaysSo) {
  for (const char* const text : {"x", "line\\n"}) {
    rb_does("perl -e 'print \"" + std::string(text) + "\" x 60000'");
    ask(JobKind::kVerify, "first");
    const Job job = until(JobState::kDone);
    const std::string document = joined(jobs.due_parts(), job.job);
    EXPECT_LE(document.size(), static_cast<std::size_t>(kMostParts) * kPartBytes);
    EXPECT_GT(document.size(), static_cast<std::size_t>(kMostParts - 1) * kPartBytes);
    EXPECT_TRUE(document.ends_with("rb says all of it in a terminal\n"));
  }
}

// Read completely, these outputs would take more memory than there is.
TEST_F(JobsTest, WhatAJobWritesIsReadNoFurtherThanItCanBeShown) {
  for (const char* const stream : {"STDOUT", "STDERR"}) {
    rb_does("perl -e 'truncate(" + std::string(stream) + ", 1e12)'");
    ask(JobKind::kVerify, "first");
    const Job job = until(JobState::kDone);
    EXPECT_TRUE(joined(jobs.due_parts(), job.job).ends_with("rb says all of it in a terminal\n")) << stream;
  }
  rb_does("perl -e 'truncate(STDERR, 1e12); seek(STDERR, 0, 2); print STDERR \"\\nthe end\"; exit 4'");
  ask(JobKind::kVerify, "first");
  EXPECT_EQ(until(JobState::kFailed).text, "the end");
  rb_does("perl -e 'open(F, \">\", $ARGV[5]); truncate(F, 1e12)' -- \"$@\"");
  ask(JobKind::kReport, "second/before=first");
  EXPECT_NE(until(JobState::kDone).text.find("too long to be shown"), std::string::npos);
}

TEST_F(JobsTest, ManyJobsKeepTheNewestAndAllTheirDocumentsAreSaidAgain) {
  rb_does("echo \"$2\"");
  for (int k = 0; k < kMostJobs + 3; ++k) {
    ask(JobKind::kVerify, k % 2 == 0 ? "first" : "second");
    until(JobState::kDone);
    (void)jobs.due_parts();
  }
  const auto reported = jobs.reported();
  ASSERT_EQ(reported.size(), static_cast<std::size_t>(kMostJobs));
  std::vector<bool> sent(kMostJobs, false);
  for (int k = 0; k < kMostJobs; ++k)
    for (const auto& part : jobs.due_parts()) sent[static_cast<std::size_t>(part.place)] = true;
  EXPECT_EQ(std::ranges::count(sent, true), kMostJobs);
}

}  // namespace
}  // namespace roadbalance
