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
  static RecordingReceipt complete(const std::string& name) {
    RecordingReceipt receipt{.name = name, .vehicle = "a car"};
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

}  // namespace
}  // namespace roadbalance
