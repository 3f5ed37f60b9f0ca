#include "host/receipts/recordings_list.hpp"

#include <gtest/gtest.h>

#include <fstream>

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
  RecordingReceipt complete(const std::string& name) const {
    RecordingReceipt receipt{.name = name, .vehicle = "a car", .place = folder.path().string()};
    receipt.state = RecordingState::kComplete;
    return receipt;
  }
  std::vector<RecordingReceipt> look(FileTime now = kNow) {
    list.look(now);
    return list.told();
  }

  test::TemporaryDirectory folder;
  RecordingsList list{folder.path()};
};

TEST_F(List, OfNoRecordingSaysSo) {
  fs::create_directories(folder.path() / "photographs");
  const auto told = look();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].recordings, 0);
  EXPECT_EQ(told[0].name, "");
}

// What rb select or a transfer makes here is none yet, and no recording that grows.
TEST_F(List, PassesOverWhatIsHalfMade) {
  write("monday", kNow - kLongAgo);
  write("tuesday.part", kNow);
  const auto told = look();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].name, "monday");
  EXPECT_FALSE(list.grows());
}

TEST_F(List, TellsTheNewestFirstAndAsksForEachReceiptOnce) {
  write("monday", kNow - 2 * kLongAgo);
  write("tuesday", kNow - kLongAgo);
  auto told = look();
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0].name, "tuesday");
  EXPECT_EQ(told[1].name, "monday");
  EXPECT_EQ(told[1].number, 1);
  EXPECT_EQ(told[1].recordings, 2);
  EXPECT_EQ(told[0].bytes, 5);
  EXPECT_EQ(told[0].state, RecordingState::kNotRead);
  ASSERT_EQ(list.unread_one(), folder.path() / "tuesday");
  list.take(complete("tuesday"));
  ASSERT_EQ(list.unread_one(), folder.path() / "monday");
  list.take(complete("monday"));
  EXPECT_EQ(list.unread_one(), std::nullopt);
  told = look();
  EXPECT_EQ(told[0].state, RecordingState::kComplete);
  EXPECT_EQ(told[0].vehicle, "a car");
}

TEST_F(List, ReadsNothingWhileARecorderWrites) {
  write("monday", kNow - kLongAgo);
  write("today", kNow - std::chrono::seconds(1));
  EXPECT_EQ(look()[0].state, RecordingState::kGrowing);
  EXPECT_EQ(list.unread_one(), std::nullopt);
  // It has ended.
  EXPECT_EQ(look(kNow + RecordingsList::kQuiet)[0].state, RecordingState::kNotRead);
  EXPECT_EQ(list.unread_one(), folder.path() / "today");
}

// A rest was fetched into it while its receipt was made.
TEST_F(List, PassesOverAReceiptOfWhatHasChangedSince) {
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
  const auto told = look();
  EXPECT_EQ(told[0].state, RecordingState::kNotRead);
  EXPECT_EQ(told[0].bytes, 10);
  EXPECT_NE(list.unread_one(), std::nullopt);
}

TEST_F(List, AReceiptThatComesWhileItGrowsAgainIsOld) {
  write("monday", kNow - kLongAgo);
  look();
  write("monday", kNow);
  look();
  list.take(complete("monday"));
  EXPECT_EQ(list.told()[0].state, RecordingState::kGrowing);
}

TEST_F(List, ForgetsWhatIsGone) {
  write("monday", kNow - kLongAgo);
  look();
  fs::remove_all(folder.path());
  EXPECT_EQ(look()[0].recordings, 0);
}

TEST_F(List, TellsNoMoreThanAPageTakes) {
  for (int k = 0; k < kMostRecordings + 3; ++k)
    write("drive" + std::to_string(k), kNow - kLongAgo - std::chrono::minutes(k));
  const auto told = look();
  ASSERT_EQ(told.size(), static_cast<std::size_t>(kMostRecordings));
  EXPECT_EQ(told[0].name, "drive0");
}

TEST_F(List, ResultsAreListedWhenTheyAreWholeAndNeverHoldBackTheDisk) {
  const fs::path results = folder.path() / "results";
  RecordingsList both{folder.path(), results};
  write("monday", kNow - 2 * kLongAgo);
  write("results/monday", kNow - kLongAgo);
  write("results/monday-selected", kNow);
  write("results/monday-selected-2.part", kNow);
  both.look(kNow);
  const auto told = both.told();
  ASSERT_EQ(told.size(), 3U);
  EXPECT_EQ(told[0].name, "monday-selected");
  EXPECT_EQ(told[0].state, RecordingState::kNotRead);
  EXPECT_EQ(told[1].name, "monday (result)");
  EXPECT_EQ(told[2].name, "monday");
  EXPECT_EQ(told[1].place, results.string());
  EXPECT_FALSE(both.grows());
  ASSERT_EQ(both.unread_one(), results / "monday-selected");
  RecordingReceipt receipt = complete("monday-selected");
  receipt.place = results.string();
  both.take(receipt);
  // Of the two that have one name each gets its own receipt.
  ASSERT_EQ(both.unread_one(), results / "monday");
  receipt.name = "monday";
  both.take(receipt);
  EXPECT_EQ(both.told()[1].state, RecordingState::kComplete);
  EXPECT_EQ(both.told()[2].state, RecordingState::kNotRead);
  EXPECT_EQ(both.listed()[1].folder, results / "monday");
}

}  // namespace
}  // namespace roadbalance
