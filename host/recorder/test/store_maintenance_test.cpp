#include <gtest/gtest.h>

#include <set>
#include <string>

#include "common/record/folder.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "host/recorder/test/store_drive.hpp"
#include "host/recording/manifest.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using test::DiskCall;
using test::Drive;
using test::kFolder;
using test::Outcome;

// A drive with many segments, of which few are kept.
class StoreMaintenanceTest : public ::testing::Test, protected Drive {
 protected:
  StoreMaintenanceTest() { options.keep_bytes = 100 << 10; }
};

// Marks become acknowledgements: no sync that can wait comes before them.
TEST_F(StoreMaintenanceTest, MarksAreGivenBeforeTheSegmentBeforeIsFinishedListedOrDeleted) {
  start();
  std::set<std::string> house;  // what was done of it
  disk.set_fault([&](DiskCall call, std::int64_t, const std::string& path) {
    const bool changes = call == DiskCall::kWrite || call == DiskCall::kSync || call == DiskCall::kTruncate ||
                         call == DiskCall::kUnlink;
    const std::string name = path.substr(path.rfind('/') + 1);
    if (changes && name.starts_with("manifest.json")) house.insert("listed");
    if (changes && name.find(".idx") != std::string::npos) house.insert("indexed");
    if (call == DiskCall::kTruncate && name.starts_with("seg-")) house.insert("cut");
    if (call == DiskCall::kUnlink && name.ends_with(".lcm")) house.insert("deleted");
    return Outcome{};
  });
  std::set<std::string> done;
  while (given < 500) {
    now += milliseconds(10);
    store->append(Delivery(test::numbered_block(++given)), now);
    const bool commits = store->commit_is_due(now);
    if (commits) note_durable(store->commit(now));
    ASSERT_TRUE(house.empty()) << *house.begin() << " before the marks of block " << given;
    if (!commits) store->maintain();
    EXPECT_FALSE(house.contains("cut") && house.contains("listed")) << "one piece after the other";
    done.merge(house);
    house.clear();
  }
  EXPECT_EQ(done, (std::set<std::string>{"cut", "indexed", "listed", "deleted"}));
}

// Lost by hand or with a file system: that costs nothing of the others, and no note declares that the
// recorder deleted it.
TEST_F(StoreMaintenanceTest, SegmentsThatVanishedAreNotCountedAndNotExcused) {
  options.keep_bytes = 0;
  start();
  run(milliseconds(5000), 500);
  note_durable(store->close(now));
  const auto before = segment_numbers(kFolder, disk);
  ASSERT_GT(before.size(), 6u);
  for (int number = 1; number <= 3; ++number)
    for (const auto& path : {segment_path(kFolder, number), index_path(kFolder, number)})
      ASSERT_EQ(disk.unlink(path.c_str()), 0);
  ASSERT_EQ(verify_record(kFolder, disk).verdict, Verdict::kDamaged);

  std::uint64_t bytes = 0;
  for (const int number : segment_numbers(kFolder, disk))
    bytes += size_of_file(segment_path(kFolder, number), disk);
  options.keep_bytes = static_cast<std::int64_t>(bytes) + (80 << 10);
  start();
  run(milliseconds(1000), 50);
  note_durable(store->seal(now));
  EXPECT_EQ(segment_numbers(kFolder, disk).front(), 4) << "less than the limit is there";

  options.keep_bytes = static_cast<std::int64_t>(bytes) - (80 << 10);
  start();
  run(milliseconds(1000), 50);
  note_durable(store->close(now));
  ASSERT_GT(segment_numbers(kFolder, disk).front(), 4);
  const Verification v = verify_record(kFolder, disk);
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  EXPECT_EQ(v.missing_segments, 3);
  ASSERT_EQ(v.lost.size(), 1u);
  EXPECT_EQ(v.lost[0].find("segments 4 to "), 0u) << v.lost[0];
}

TEST_F(StoreMaintenanceTest, SealingFinishesListsAndDeletesAllThatIsLeftOfIt) {
  start();
  while (given < 500) {
    now += milliseconds(10);
    store->append(Delivery(test::numbered_block(++given)), now);
    if (store->commit_is_due(now)) note_durable(store->commit(now));  // and never a time for the house
  }
  ASSERT_GT(segment_numbers(kFolder, disk).size(), 4u);
  EXPECT_TRUE(read_manifest(kFolder, disk).empty());
  note_durable(store->seal(now));
  const auto listed = read_manifest(kFolder, disk);
  const auto left = segment_numbers(kFolder, disk);
  EXPECT_LT(left.size(), 4u);
  ASSERT_EQ(listed.size(), left.size());
  for (const int number : left) {
    EXPECT_TRUE(listed.contains(segment_path(kFolder, number).filename().string()));
    EXPECT_TRUE(path_exists(index_path(kFolder, number), disk));
  }
}

// The power goes after each number of system calls of a drive with rotations, listing and deleting.
TEST_F(StoreMaintenanceTest, APowerCutBeforeTheHouseIsKeptIsToldAsWhatItIs) {
  for (std::int64_t k = 1;; k += 3) {
    Drive drive(static_cast<std::uint64_t>(k));
    drive.options.keep_bytes = 100 << 10;
    drive.start();
    drive.disk.set_fault(test::SimulatedDisk::at_call(drive.disk.calls() + k, {.power_cut = true}));
    drive.run(milliseconds(5000), 300);
    const bool reached = drive.disk.is_off();
    if (!reached) drive.disk.cut_power();
    drive.store.reset();
    drive.disk.power_on();
    drive.fail_nothing();
    if (drive.durable > 0) {
      const Verification found = verify_record(kFolder, drive.disk);
      ASSERT_EQ(found.error, "") << "call " << k;
      ASSERT_EQ(found.damaged_bytes + found.missing_segments + found.blocks_refused + found.entries_refused,
                0)
          << "call " << k << ", " << ::testing::PrintToString(found.damage);
      EXPECT_GE(drive.recorded().back(), drive.durable) << "call " << k;
    }
    if (!reached) {
      EXPECT_GT(k, 300) << "the drive has too few calls to prove much";
      return;
    }
  }
}

}  // namespace
}  // namespace roadbalance
