#include "host/recordings/recordings_list.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "common/record/file.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;
using FileTime = RecordingsList::FileTime;

const FileTime kNow = FileTime::clock::now();
constexpr std::chrono::seconds kLongAgo{3600};

class List : public testing::Test {
 protected:
  void write(const std::string& name, FileTime changed) {
    fs::create_directories(folder.path() / name);
    const fs::path file = folder.path() / name / "seg-000001.lcm";
    std::ofstream(file, std::ios::app) << "12345";
    fs::last_write_time(file, changed);
  }
  /// As its recorder does.
  File lock(const std::string& name) const {
    File file = File::open_folder(folder.path() / name);
    EXPECT_TRUE(file.try_lock());
    return file;
  }
  RecordingSummary complete(const std::string& name) const {
    RecordingSummary summary{.name = name, .vehicle = "a car", .place = folder.path().string()};
    summary.state = RecordingState::kComplete;
    return summary;
  }
  std::vector<RecordingSummary> look(FileTime now = kNow) {
    list.look(now);
    return list.reported();
  }

  test::TemporaryDirectory folder;
  RecordingsList list{folder.path()};
};

TEST_F(List, OfNoRecordingSaysSo) {
  fs::create_directories(folder.path() / "photographs");
  const auto reported = look();
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_EQ(reported[0].recordings, 0);
  EXPECT_EQ(reported[0].name, "");
}

// An unfinished result of rb select or of a transfer is no recording yet, and does not grow.
TEST_F(List, PassesOverWhatIsHalfMade) {
  write("monday", kNow - kLongAgo);
  write("tuesday.part", kNow);
  const auto reported = look();
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_EQ(reported[0].name, "monday");
  EXPECT_FALSE(list.grows());
}

TEST_F(List, ListsTheNewestFirstAndAsksForEachSummaryOnce) {
  write("monday", kNow - 2 * kLongAgo);
  write("tuesday", kNow - kLongAgo);
  auto reported = look();
  ASSERT_EQ(reported.size(), 2U);
  EXPECT_EQ(reported[0].name, "tuesday");
  EXPECT_EQ(reported[1].name, "monday");
  EXPECT_EQ(reported[1].number, 1);
  EXPECT_EQ(reported[1].recordings, 2);
  EXPECT_EQ(reported[0].bytes, 5);
  EXPECT_EQ(reported[0].state, RecordingState::kNotRead);
  ASSERT_EQ(list.unread_one(), folder.path() / "tuesday");
  list.take(complete("tuesday"));
  ASSERT_EQ(list.unread_one(), folder.path() / "monday");
  list.take(complete("monday"));
  EXPECT_EQ(list.unread_one(), std::nullopt);
  reported = look();
  EXPECT_EQ(reported[0].state, RecordingState::kComplete);
  EXPECT_EQ(reported[0].vehicle, "a car");
}

TEST_F(List, ReadsNothingWhileARecorderWrites) {
  write("monday", kNow - kLongAgo);
  write("today", kNow - std::chrono::seconds(1));
  const File recorder = lock("today");
  EXPECT_EQ(look()[0].state, RecordingState::kGrowing);
  EXPECT_EQ(list.unread_one(), std::nullopt);
  // It has ended.
  EXPECT_EQ(look(kNow + RecordingsList::kQuiet)[0].state, RecordingState::kNotRead);
  EXPECT_EQ(list.unread_one(), folder.path() / "today");
}

TEST_F(List, ACopyThatIsJustMadeIsNotBeingRecorded) {
  write("copy", kNow);
  EXPECT_EQ(look()[0].state, RecordingState::kNotRead);
  EXPECT_EQ(list.unread_one(), folder.path() / "copy");
}

// Its missing part was fetched into it while its summary was made.
TEST_F(List, IgnoresASummaryOfARecordingThatHasChangedSince) {
  write("monday", kNow - 2 * kLongAgo);
  look();
  ASSERT_EQ(list.unread_one(), folder.path() / "monday");
  write("monday", kNow - kLongAgo);
  look();
  list.take(complete("monday"));
  EXPECT_EQ(look()[0].state, RecordingState::kNotRead);
  ASSERT_EQ(list.unread_one(), folder.path() / "monday");
  list.take(complete("monday"));
  EXPECT_EQ(look()[0].state, RecordingState::kComplete);
}

TEST_F(List, ReadsAgainWhatHasChanged) {
  write("monday", kNow - kLongAgo);
  look();
  list.take(complete("monday"));
  write("monday", kNow - kLongAgo / 2);
  const auto reported = look();
  EXPECT_EQ(reported[0].state, RecordingState::kNotRead);
  EXPECT_EQ(reported[0].bytes, 10);
  EXPECT_NE(list.unread_one(), std::nullopt);
}

TEST_F(List, ASummaryThatComesWhileItGrowsAgainIsOld) {
  write("monday", kNow - kLongAgo);
  look();
  write("monday", kNow);
  const File recorder = lock("monday");
  look();
  list.take(complete("monday"));
  EXPECT_EQ(list.reported()[0].state, RecordingState::kGrowing);
}

TEST_F(List, ForgetsWhatIsGone) {
  write("monday", kNow - kLongAgo);
  look();
  fs::remove_all(folder.path());
  EXPECT_EQ(look()[0].recordings, 0);
}

TEST_F(List, ListsNoMoreThanAPageTakes) {
  for (int k = 0; k < kMostRecordings + 3; ++k)
    write("drive" + std::to_string(k), kNow - kLongAgo - std::chrono::minutes(k));
  const auto reported = look();
  ASSERT_EQ(reported.size(), static_cast<std::size_t>(kMostRecordings));
  EXPECT_EQ(reported[0].name, "drive0");
}

TEST_F(List, ResultsAreListedWhenTheyAreWholeAndNeverHoldBackTheDisk) {
  const fs::path results = folder.path() / "results";
  RecordingsList both{folder.path(), results};
  write("monday", kNow - 2 * kLongAgo);
  write("results/monday", kNow - kLongAgo);
  write("results/monday-selected", kNow);
  write("results/monday-selected-2.part", kNow);
  both.look(kNow);
  const auto reported = both.reported();
  ASSERT_EQ(reported.size(), 3U);
  EXPECT_EQ(reported[0].name, "monday-selected");
  EXPECT_EQ(reported[0].state, RecordingState::kNotRead);
  EXPECT_EQ(reported[1].name, "monday (result)");
  EXPECT_EQ(reported[2].name, "monday");
  EXPECT_EQ(reported[1].place, results.string());
  EXPECT_FALSE(both.grows());
  ASSERT_EQ(both.unread_one(), results / "monday-selected");
  RecordingSummary summary = complete("monday-selected");
  summary.place = results.string();
  both.take(summary);
  // Two recordings of one name get a summary each.
  ASSERT_EQ(both.unread_one(), results / "monday");
  summary.name = "monday";
  both.take(summary);
  EXPECT_EQ(both.reported()[1].state, RecordingState::kComplete);
  EXPECT_EQ(both.reported()[2].state, RecordingState::kNotRead);
  EXPECT_EQ(both.listed()[1].folder, results / "monday");
}

}  // namespace
}  // namespace roadbalance
