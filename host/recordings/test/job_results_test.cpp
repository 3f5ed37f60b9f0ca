#include "host/recordings/job_results.hpp"

#include <map>

#include "host/recordings/byte_rate.hpp"
#include "host/recordings/job_book.hpp"
#include "host/recordings/test/jobs_fixture.hpp"

namespace roadbalance {
namespace {

TEST_F(JobsTest, WhatAJobMakesGetsAFreeNameAmongTheResults) {
  rb_does("while [ \"$1\" != --output ]; do shift; done; echo 12345 > \"$2\"");
  const auto made = [&](JobKind kind, const std::string& text) {
    EXPECT_EQ(ask(kind, text).state, AnswerState::kDone) << text;
    return until(JobState::kDone).text;
  };
  EXPECT_EQ(made(JobKind::kSelect, "first/from=1/to=2.5"),
            (results / "first-selected").string() + ", 0.0 MB");
  EXPECT_EQ(made(JobKind::kSelect, "first"), (results / "first-selected-2").string() + ", 0.0 MB");
  EXPECT_EQ(made(JobKind::kReduce, "first/rate=500"),
            (results / "first-reduced-500Hz").string() + ", 0.0 MB");
  EXPECT_EQ(made(JobKind::kExport, "first/format=hdf5"), (results / "first.h5").string() + ", 0.0 MB");
  EXPECT_EQ(made(JobKind::kReport, "first/complete=yes"),
            (results / "first-report.html").string() + ", 0.0 MB");
  // Neither another program's unfinished result nor the name of a recording is taken.
  std::ofstream(results / "second.csv.part") << "half";
  known.push_back({{.name = "second-selected", .vehicle = ""}, folder.path() / "second-selected"});
  EXPECT_EQ(made(JobKind::kExport, "second/format=csv"), (results / "second-2.csv").string() + ", 0.0 MB");
  EXPECT_EQ(made(JobKind::kSelect, "second"), (results / "second-selected-2").string() + ", 0.0 MB");
  EXPECT_TRUE(fs::exists(results / "second.csv.part"));
}

TEST_F(JobsTest, ACandumpLogComesWithTheFileThatTellsWhatItsFramesMean) {
  rb_does("for word; do echo \"[$word]\"; done");
  fs::create_directories(results);
  std::ofstream(results / "first.dbc") << "of somebody else";
  ask(JobKind::kExport, "first/format=candump");
  const Job job = until(JobState::kDone);
  EXPECT_EQ(joined(jobs.due_parts(), job.job), "[export]\n[" + (folder.path() / "first").string() +
                                                   "]\n[--format=candump]\n[--output]\n[" +
                                                   (results / "first-2.log").string() + "]\n[--dbc]\n[" +
                                                   (results / "first-2.dbc").string() + "]\n");
}

/// The short report is sent in parts; the complete report is too long for that.
TEST_F(JobsTest, ACompleteReportIsAFileAmongTheResults) {
  rb_does("for word; do echo \"[$word]\"; done");
  ask(JobKind::kReport, "second/before=first/complete=yes");
  const Job job = until(JobState::kDone);
  EXPECT_EQ(job.document_kind, DocumentKind::kText);
  EXPECT_EQ(joined(jobs.due_parts(), job.job), "[report]\n[" + (folder.path() / "second").string() +
                                                   "]\n[--before]\n[" + (folder.path() / "first").string() +
                                                   "]\n[--complete]\n[--output]\n[" +
                                                   (results / "second-report.html").string() + "]\n");
  EXPECT_EQ(ask(JobKind::kReport, "second/complete=no").reason, RefusalReason::kBadArgument);
  EXPECT_EQ(ask(JobKind::kVerify, "second/complete=yes").reason, RefusalReason::kBadArgument);
}

TEST_F(JobsTest, OptionsReachTheCommandInOneWordEach) {
  rb_does("for word; do echo \"[$word]\"; done");
  ask(JobKind::kSelect, "first/from=-3/to-mark=2/channels=--json,$(touch x); a b");
  const Job job = until(JobState::kDone);
  EXPECT_EQ(joined(jobs.due_parts(), job.job), "[select]\n[" + (folder.path() / "first").string() +
                                                   "]\n[--channels=--json,$(touch x); a b]\n[--from=-3]\n"
                                                   "[--to-mark=2]\n[--output]\n[" +
                                                   (results / "first-selected").string() + "]\n");
}

TEST_F(JobsTest, RefusesOptionsThatCannotBeAndSaysWhich) {
  rb_does("exit 0");
  const auto refused = [&](JobKind kind, const std::string& text) {
    const Answer answer = ask(kind, text);
    EXPECT_EQ(answer.reason, RefusalReason::kBadArgument) << text;
    return answer.text;
  };
  EXPECT_EQ(refused(JobKind::kExport, "first"), "rb export needs a format");
  EXPECT_EQ(refused(JobKind::kExport, "first/format=exe"),
            "format \"exe\": allowed: mdf4, hdf5, mat, uff58, wav, csv, mcap, candump");
  EXPECT_EQ(refused(JobKind::kReduce, "first/rate=0"), "rate \"0\": allowed: samples a second");
  EXPECT_EQ(refused(JobKind::kReduce, "first/rate=../../x"), "rate \"..\": allowed: samples a second");
  EXPECT_EQ(refused(JobKind::kSelect, "first/from=nan"), "from \"nan\": allowed: seconds");
  EXPECT_EQ(refused(JobKind::kSelect, "first/from=1/from=2"), "from is said twice");
  EXPECT_EQ(refused(JobKind::kSelect, "first/from-mark=-1"),
            "from-mark \"-1\": allowed: the number of a mark");
  EXPECT_EQ(refused(JobKind::kSelect, "first/output=x"), "\"output=x\" says nothing of a job");
  EXPECT_EQ(refused(JobKind::kSelect, "first/rate=500"), "rate \"500\" has no meaning for rb select");
  EXPECT_EQ(refused(JobKind::kTransfer, "first/to=3"), "to \"3\" has no meaning for rb transfer");
  EXPECT_FALSE(fs::exists(results)) << "nothing was begun";
}

TEST_F(JobsTest, ATransferGoesWhereTheMachinesOperatorSaysOrNowhere) {
  rb_does("echo \"$@\"");
  EXPECT_EQ(ask(JobKind::kTransfer, "first").state, AnswerState::kDone);
  EXPECT_EQ(until(JobState::kDone).text,
            "transfer " + (folder.path() / "first").string() + " --to " + disk.string());
  Jobs nowhere(rb, {results, ""});
  const auto answer = nowhere.take({.asker = 1,
                                    .request = 5,
                                    .operation = Operation::kJob,
                                    .value = {static_cast<double>(JobKind::kTransfer), 0},
                                    .text = "first"},
                                   known, false, at(++utc_us));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->reason, RefusalReason::kNotSupported);
  EXPECT_NE(answer->text.find("--transfer-to"), std::string::npos) << answer->text;
}

TEST_F(JobsTest, OfACancelledExportNothingIsLeftEvenIfItIsDeaf) {
  rb_does("trap '' TERM; echo half > \"$5.part\"; while :; do sleep 0.1; done");
  ask(JobKind::kExport, "first/format=csv");
  for (int k = 0; k < 12'000 && !fs::exists(results / "first.csv.part"); ++k) {
    jobs.turn(false, at(utc_us += 10'000));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  cancel(newest().job);
  EXPECT_EQ(until(JobState::kCancelled).text,
            "cancelled; nothing is left of it, and begun again it begins anew");
  EXPECT_FALSE(fs::exists(results / "first.csv.part"));
}

TEST_F(JobsTest, AJobUnderWayAtTheEndIsReportedAsInterrupted) {
  rb_does("[ \"$1\" = transfer ] && exec sleep 60; echo half > \"$5.part\"; exec sleep 60");
  const fs::path half = results / "first.csv.part", other = results / "second.csv.part";
  const Request asked{.asker = 1,
                      .request = 70,
                      .operation = Operation::kJob,
                      .value = {static_cast<double>(JobKind::kExport), 0},
                      .text = "first/format=csv"};
  {
    Jobs killed(rb, places);
    ASSERT_TRUE(killed.take(asked, known, false, at(2)));
    for (int k = 0; k < 12'000 && !fs::exists(half); ++k)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  std::ofstream(half) << "half";
  std::ofstream(other) << "of somebody else";
  Jobs again(rb, places);
  auto reported = again.reported();
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_EQ(reported[0].state, JobState::kInterrupted);
  EXPECT_EQ(reported[0].options, "format=csv");
  EXPECT_NE(reported[0].text.find("begins anew"), std::string::npos) << reported[0].text;
  EXPECT_FALSE(fs::exists(half));
  EXPECT_TRUE(fs::exists(other));
  // The page missed the answer and asks once more: that is no second job.
  EXPECT_EQ(again.take(asked, known, false, at(3))->state, AnswerState::kDone);
  EXPECT_EQ(again.reported().size(), 1U);
  // A new request begins a second job, and this, too, is stored.
  Request anew = asked;
  anew.request = 71;
  rb_does("echo whole > \"$5\"");
  ASSERT_EQ(again.take(anew, known, false, at(4))->state, AnswerState::kDone);
  for (int k = 0; k < 12'000 && again.reported()[1].state == JobState::kRunning; ++k) {
    again.turn(false, at(5 + k));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  Jobs third(rb, places);
  reported = third.reported();
  ASSERT_EQ(reported.size(), 2U);
  EXPECT_EQ(reported[0].state, JobState::kInterrupted);
  EXPECT_EQ(reported[1].state, JobState::kDone);
  EXPECT_EQ(reported[1].text, (results / "first.csv").string() + ", 0.0 MB");
}

TEST_F(JobsTest, ABookThatCannotBeReadEndsNothing) {
  fs::create_directories(results);
  for (
      const char* const text :
      {"", "{", "[{}]", "[[[[]]]]", R"([{"job":1,"kind":4e52}])", R"([{"job":99999999999999999999}])",
       R"([{"job":1,"kind":4,"state":1,"recording":"a","options":"","began_us":0,"ended_us":0,"elapsed_s":0,)"
       R"("text":"","asked":[1,2],"result":"../second.csv"}])"}) {
    std::ofstream(results / kJobBookFile) << text;
    EXPECT_EQ(Jobs(rb, places).reported()[0].jobs, 0) << text;
  }
}

TEST_F(JobsTest, ResultsThatCannotBeWrittenAreRefusedAndNamed) {
  std::ofstream(folder.path() / "results") << "a file";
  rb_does("exit 0");
  const Answer answer = ask(JobKind::kSelect, "first");
  EXPECT_EQ(answer.reason, RefusalReason::kDisk);
  EXPECT_NE(answer.text.find(results.string()), std::string::npos) << answer.text;
  EXPECT_EQ(ask(JobKind::kVerify, "first").state, AnswerState::kDone) << "which needs no such place";
  until(JobState::kDone);
}

TEST_F(JobsTest, WhatStaysOnADiskStandsInTheBookBeforeItBegins) {
  rb_does("cat " + (results / kJobBookFile).string());
  ask(JobKind::kTransfer, "first");
  const Job job = until(JobState::kDone);
  const auto booked = decode_job_book(joined(jobs.due_parts(), job.job), results);
  ASSERT_TRUE(booked);
  ASSERT_EQ(booked->size(), 1U);
  EXPECT_EQ(booked->front().job.job, job.job);
  EXPECT_EQ(booked->front().job.state, JobState::kRunning);
}

TEST_F(JobsTest, WithoutItsBookNothingThatStaysIsBegun) {
  const fs::path obstacle = results / (std::string(kJobBookFile) + ".new"), begun = folder.path() / "begun";
  fs::create_directories(obstacle / "full");
  rb_does("[ \"$1\" = verify ] || touch " + begun.string());
  for (const auto& [kind, text] : std::map<JobKind, std::string>{{JobKind::kExport, "first/format=csv"},
                                                                 {JobKind::kSelect, "first"},
                                                                 {JobKind::kReduce, "first/rate=500"},
                                                                 {JobKind::kTransfer, "first"}}) {
    const Answer answer = ask(kind, text);
    EXPECT_EQ(answer.state, AnswerState::kRefused);
    EXPECT_EQ(answer.reason, RefusalReason::kDisk);
    EXPECT_NE(answer.text.find("book of jobs"), std::string::npos) << answer.text;
    EXPECT_NE(answer.text.find(obstacle.string()), std::string::npos) << answer.text;
  }
  EXPECT_EQ(jobs.reported()[0].jobs, 0);
  EXPECT_EQ(ask(JobKind::kVerify, "first").state, AnswerState::kDone) << "of which nothing stays";
  until(JobState::kDone);
  EXPECT_FALSE(fs::exists(begun));
  // The disk takes it again: jobs done meanwhile are not lost.
  fs::remove_all(obstacle);
  jobs.turn(false, at(utc_us += 10'000'000));
  EXPECT_EQ(Jobs(rb, places).reported()[0].state, JobState::kDone);
}

TEST_F(JobsTest, AJobThatCouldNotBeStartedIsNotInTheBook) {
  EXPECT_EQ(ask(JobKind::kSelect, "first").reason, RefusalReason::kNotSupported);
  EXPECT_EQ(Jobs(rb, places).reported()[0].jobs, 0);
}

TEST_F(JobsTest, ABookOfLongTextsIsReadAgain) {
  std::vector<BookedJob> booked;
  for (int k = 1; k <= kMostJobs; ++k)
    booked.push_back({.job = {.job = k,
                              .kind = JobKind::kVerify,
                              .state = JobState::kFailed,
                              .recording = "first",
                              .text = std::string(100'000, 'x')}});
  fs::create_directories(results);
  std::ofstream(results / kJobBookFile) << encode_job_book(booked);
  const auto reported = Jobs(rb, places).reported();
  ASSERT_EQ(reported.size(), static_cast<std::size_t>(kMostJobs));
  EXPECT_EQ(reported[0].text, std::string(300, 'x'));
}

TEST_F(JobsTest, AFolderThatCannotBeLookedIntoEndsTheSearchForAName) {
  fs::create_symlink(results, results);  // ELOOP: as EACCES and EIO, and root meets it, too
  int asked = 0;
  const auto is_taken = [&](const std::string&) {
    if (++asked > 10) throw std::logic_error("it goes on and on");
    return false;
  };
  EXPECT_THROW(free_place(results, {.stem = "first", .extension = ".h5"}, is_taken), fs::filesystem_error);
}

TEST_F(JobsTest, TheSearchForANameEndsWhenAllAreTaken) {
  int asked = 0;
  const auto is_taken = [&](const std::string&) {
    if (++asked > 100'000) throw std::logic_error("it goes on and on");
    return true;
  };
  EXPECT_THROW(free_place(folder.path(), {.stem = "first", .extension = ".h5"}, is_taken),
               std::runtime_error);
}

TEST(ByteRate, IsThatOfTheLastSecondsAndForgetsAPause) {
  ByteRate rate;
  EXPECT_EQ(rate.bytes_per_s(), 0);
  const auto at = [](std::int64_t us) { return WallTime(std::chrono::microseconds(us)); };
  for (int k = 0; k <= 100; ++k) rate.take(k * 1000, at(k * 100'000));
  EXPECT_DOUBLE_EQ(rate.bytes_per_s(), 10'000);
  // Twice as fast for longer than it looks back.
  for (int k = 1; k <= 60; ++k) rate.take(100'000 + k * 2000, at(10'000'000 + k * 100'000));
  EXPECT_DOUBLE_EQ(rate.bytes_per_s(), 20'000);
  rate.forget();
  rate.take(300'000, at(100'000'000));
  EXPECT_EQ(rate.bytes_per_s(), 0) << "one point has no rate";
  rate.take(310'000, at(101'000'000));
  EXPECT_DOUBLE_EQ(rate.bytes_per_s(), 10'000);
}

}  // namespace
}  // namespace roadbalance
