#include "common/record/test/simulated_disk.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <utility>

#include "common/record/file.hpp"
#include "common/record/folder.hpp"

namespace roadbalance::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes pattern(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  Bytes bytes(size);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(1 + random() % 255);  // never 0
  return bytes;
}

void restart(SimulatedDisk& disk) {
  disk.cut_power();
  disk.power_on();
}

TEST(SimulatedDisk, WhatIsSyncedWithItsNameSurvivesEveryPowerCut) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SimulatedDisk disk(seed);
    create_folders("/a/b", disk);
    File file = File::create("/a/b/file", disk);
    const Bytes kept = pattern(1000 + 37 * seed, seed);
    file.write_all(kept);
    file.sync_data();
    sync_folder("/a/b", disk);
    const Bytes more = pattern(5000, seed + 1);
    file.write_all(more);
    restart(disk);
    Bytes found = disk.content("/a/b/file");
    ASSERT_GE(found.size(), kept.size());
    found.resize(kept.size());
    ASSERT_EQ(found, kept) << seed;
  }
}

// Whole sectors, each the old or the new one, and not always the same ones.
TEST(SimulatedDisk, WhatIsNotSyncedIsTornBySectors) {
  std::set<Bytes> outcomes;
  int complete = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    SimulatedDisk disk(seed);
    File file = File::create("/file", disk);
    const Bytes first = pattern(700, 1);
    file.write_all(first);
    file.sync_data();
    sync_folder("/", disk);
    const Bytes more = pattern(3000, 2);
    file.write_all(more);
    restart(disk);
    const Bytes found = disk.content("/file");
    Bytes whole = first;
    whole.insert(whole.end(), more.begin(), more.end());
    Bytes before = first;
    before.resize(whole.size());
    for (std::size_t sector = 0; sector < 2 * 512; sector += 512) {  // without stale content: the old end
      const auto end = static_cast<std::ptrdiff_t>(std::min<std::size_t>(sector + 512, found.size()));
      const auto from = static_cast<std::ptrdiff_t>(sector);
      const Bytes part(found.begin() + from, found.begin() + end);
      const bool is_new = std::equal(part.begin(), part.end(), whole.begin() + from);
      const bool is_old = std::equal(part.begin(), part.end(), before.begin() + from);
      ASSERT_TRUE(is_new || is_old) << "seed " << seed << " sector " << sector / 512;
    }
    outcomes.insert(found);
    complete += found == whole ? 1 : 0;
  }
  EXPECT_GT(outcomes.size(), 50u);
  EXPECT_GT(complete, 0);
}

TEST(SimulatedDisk, ANameThatIsNotSyncedMayBeLost) {
  int lost = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    SimulatedDisk disk(seed);
    File file = File::create("/file", disk);
    file.sync();
    restart(disk);
    lost += path_exists("/file", disk) ? 0 : 1;
  }
  EXPECT_GT(lost, 20);
  EXPECT_LT(lost, 80);
}

TEST(SimulatedDisk, ARenameHappensAsAWholeOrNotAtAll) {
  std::set<std::string> seen;
  for (unsigned seed = 0; seed < 100; ++seed) {
    SimulatedDisk disk(seed);
    write_atomically("/file", "old", disk);
    File next = File::create("/file.new", disk);
    next.write_all(Bytes{'n', 'e', 'w'});
    next.sync();
    rename_file("/file.new", "/file", disk);
    restart(disk);
    const auto text = read_text("/file", disk);
    ASSERT_TRUE(text);
    seen.insert(*text);
  }
  EXPECT_EQ(seen, (std::set<std::string>{"old", "new"}));
}

// As on Linux: the second sync returns success, and the data is not there.
TEST(SimulatedDisk, AfterAFailedSyncTheNextOneSucceedsButTheDataMayBeLost) {
  int lost = 0;
  const Bytes data = pattern(4096, 3);
  for (unsigned seed = 0; seed < 50; ++seed) {
    SimulatedDisk disk(seed);
    File file = File::create("/file", disk);
    sync_folder("/", disk);
    file.write_all(data);
    disk.set_fault(SimulatedDisk::at_call(disk.calls() + 1, {.error = EIO}));
    EXPECT_THROW(file.sync_data(), std::system_error);
    EXPECT_NO_THROW(file.sync_data());
    EXPECT_EQ(disk.content("/file"), data) << "the page cache has it";
    restart(disk);
    EXPECT_EQ(disk.content("/file").size(), data.size());
    lost += disk.content("/file") == data ? 0 : 1;
  }
  EXPECT_GT(lost, 40);
}

TEST(SimulatedDisk, ACutThatIsNotSyncedMayBeUndone) {
  std::set<std::size_t> sizes;
  const Bytes data = pattern(3000, 4);
  for (unsigned seed = 0; seed < 50; ++seed) {
    SimulatedDisk disk(seed);
    disk.put("/file", data);
    File::open_to_write("/file", disk).truncate(700);
    restart(disk);
    Bytes found = disk.content("/file");
    sizes.insert(found.size());
    ASSERT_EQ(found, Bytes(data.begin(), data.begin() + static_cast<std::ptrdiff_t>(found.size())));
  }
  EXPECT_EQ(sizes, (std::set<std::size_t>{700, 3000}));
}

TEST(SimulatedDisk, AFullDiskTakesWhatFitsAndGivesSpaceBackWithTheFile) {
  SimulatedDisk disk;
  disk.set_capacity(8192);
  File file = File::create("/file", disk);
  EXPECT_THROW(file.write_all(pattern(10'000, 5)), std::system_error);
  EXPECT_EQ(size_of_file("/file", disk), 8192u);
  EXPECT_EQ(disk.free_bytes("/"), 0);
  file.close();
  remove_file("/file", disk);
  sync_folder("/", disk);
  EXPECT_EQ(disk.free_bytes("/"), 8192);
}

TEST(SimulatedDisk, WhatIsMountedHidesWhatLiesBeneathAndKeepsWhatItHolds) {
  SimulatedDisk disk;
  create_folders("/a/b", disk);
  disk.put("/a/b/beneath", {1});
  const auto device = [&disk](const char* path) {
    return disk.identity(path).value_or(FileIdentity{}).device;
  };
  const std::int64_t own = device("/a/b");
  disk.mount("/a/b");
  const std::int64_t mounted = device("/a/b");
  EXPECT_NE(mounted, own);
  EXPECT_EQ(device("/a"), own);
  EXPECT_FALSE(path_exists("/a/b/beneath", disk));
  File file = File::create("/a/b/file", disk);
  disk.unmount("/a/b");
  EXPECT_EQ(device("/a/b"), own);
  EXPECT_FALSE(file.is_at("/a/b/file"));
  EXPECT_TRUE(path_exists("/a/b/beneath", disk));
  EXPECT_FALSE(path_exists("/a/b/file", disk));
  file.write_all(Bytes{2});
  disk.mount("/a/b");
  EXPECT_EQ(disk.content("/a/b/file"), Bytes{2});
  EXPECT_EQ(device("/a/b"), mounted);
  EXPECT_TRUE(file.is_at("/a/b/file"));
  EXPECT_FALSE(disk.identity("/a/c"));
}

TEST(SimulatedDisk, WhatIsOpenOfADiskThatIsPluggedInAnewIsNotIt) {
  SimulatedDisk disk;
  create_folders("/a", disk);
  disk.mount("/a");
  File folder = File::open_folder("/a", disk), file = File::create("/a/file", disk);
  ASSERT_TRUE(folder.try_lock());
  file.write_all(Bytes{1});
  disk.unmount("/a");
  disk.plug_in("/a");
  EXPECT_EQ(disk.content("/a/file"), Bytes{1});
  EXPECT_FALSE(file.is_at("/a/file"));
  EXPECT_FALSE(folder.is_at("/a"));
  file.write_all(Bytes{2});
  EXPECT_EQ(disk.content("/a/file"), Bytes{1});
  EXPECT_TRUE(File::open_folder("/a", disk).try_lock());
}

TEST(SimulatedDisk, OfADiskThatWasPulledOutNothingWorksButWhatWasSyncedIsThereAgain) {
  SimulatedDisk disk;
  create_folders("/a", disk);
  disk.mount("/a");
  File file = File::create("/a/file", disk);
  file.write_all(Bytes{1});
  file.sync();
  sync_folder("/a", disk);
  disk.pull_out("/a");
  EXPECT_FALSE(path_exists("/a/file", disk));
  EXPECT_THROW(file.write_all(Bytes{2}), std::system_error);
  EXPECT_THROW(file.sync(), std::system_error);
  file.close();
  disk.plug_in("/a");
  EXPECT_EQ(disk.content("/a/file"), Bytes{1});
}

TEST(SimulatedDisk, AKilledProcessLosesItsDescriptorsAndLocksAndNoData) {
  SimulatedDisk disk;
  File folder = File::open_folder("/", disk);
  ASSERT_TRUE(folder.try_lock());
  File file = File::create("/file", disk);
  file.write_all(pattern(100, 6));
  disk.kill();
  EXPECT_THROW(file.write_all(pattern(1, 7)), std::system_error);
  EXPECT_EQ(disk.content("/file"), pattern(100, 6));
  File next = File::open_folder("/", disk);
  EXPECT_TRUE(next.try_lock());
}

TEST(SimulatedDisk, ACallInWhichTheProcessIsKilledDoesNothing) {
  SimulatedDisk disk;
  bool dies = false;
  disk.set_fault([&](DiskCall, std::int64_t, const std::string&) {
    if (std::exchange(dies, false)) disk.kill();
    return SimulatedDisk::Outcome{};
  });
  const auto at_death = [&](auto&& call) {
    File folder = File::open_folder("/", disk);
    File file = File::create("/file", disk);
    file.write_all(pattern(100, 6));
    dies = true;
    EXPECT_THROW(call(folder, file), std::system_error);
    EXPECT_FALSE(dies);
    EXPECT_EQ(disk.content("/file"), pattern(100, 6));
    EXPECT_TRUE(File::open_folder("/", disk).try_lock());
    remove_file("/file", disk);
  };
  at_death([](File&, File& file) { file.write_all(pattern(1, 7)); });
  at_death([](File&, File& file) { file.truncate(3); });
  at_death([](File&, File& file) { file.sync(); });
  at_death([](File&, File& file) { file.sync_data(); });
  at_death([](File&, File& file) { static_cast<void>(file.size()); });
  at_death([](File& folder, File&) { static_cast<void>(folder.try_lock()); });
  at_death([](File&, File& file) { file.close(); });
  at_death([&](File&, File&) { remove_file("/file", disk); });
  at_death([&](File&, File&) { rename_file("/file", "/other", disk); });
}

TEST(SimulatedDisk, AnInterruptedOrShortWriteIsFinished) {
  for (const SimulatedDisk::Outcome outcome :
       {SimulatedDisk::Outcome{.error = EINTR}, SimulatedDisk::Outcome{.short_write = true}}) {
    SimulatedDisk disk;
    File file = File::create("/file", disk);
    disk.set_fault(SimulatedDisk::at_call(disk.calls() + 1, outcome));
    file.write_all(pattern(1000, 8));
    EXPECT_EQ(disk.content("/file"), pattern(1000, 8));
  }
}

}  // namespace
}  // namespace roadbalance::test
