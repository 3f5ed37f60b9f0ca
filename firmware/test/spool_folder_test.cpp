#include "firmware/spool_folder.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <fstream>
#include <random>
#include <utility>

#include "common/bus/codec.hpp"
#include "common/link/backlog.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "common/test/temporary_directory.hpp"
#include "firmware/test/spooled_blocks.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
using test::DiskCall;
using test::SimulatedDisk;
constexpr WallTime kStart{std::chrono::hours(1)};
using test::kEpoch;
using test::kNode;
using test::seal_next;
const std::filesystem::path kFolder = "/spool";

struct SpoolFolderTest : testing::Test {
  SpoolFolder::Options options{.folder = kFolder, .bytes = 4 << 20, .node = kNode, .epoch = kEpoch};
  SimulatedDisk disk;
  Ring ring{160 * sizeof(SealedBlock)};
  WallTime now = kStart;

  /// As an uplink without a recorder; until `blocks` were sealed or nothing fits any more.
  void fill(Backlog& backlog, std::int64_t blocks) {
    for (int idle = 0; ring.next() <= blocks && idle < 10;) {
      idle = ring.used() < ring.capacity() ? 0 : idle + 1;
      if (idle == 0) seal_next(ring);
      backlog.relieve(now);
      now += 10ms;
    }
  }
  std::size_t bytes_on_disk() {
    std::size_t bytes = 0;
    const auto names = disk.list(kFolder.c_str());
    for (const std::string& name : *names) bytes += disk.content((kFolder / name).string()).size();
    return bytes;
  }
  std::vector<std::int64_t> sequences_on_disk() {
    std::vector<std::int64_t> all;
    RecordReader reader(kFolder, disk);
    reader.finish();
    SealedBlock block;
    while (const auto event = reader.next()) {
      EXPECT_EQ(accept(event->data, block), Refusal::kNone);
      all.push_back(block.header.sequence);
    }
    EXPECT_TRUE(reader.damage().empty());
    return all;
  }
};

TEST_F(SpoolFolderTest, GivesEveryBlockBackAsItWasSealed) {
  SpoolFolder spool(options, disk);
  Backlog backlog(ring, &spool);
  fill(backlog, 1500);
  EXPECT_GT(backlog.spooled(), 1300);
  EXPECT_EQ(backlog.spool_failures(), 0);
  Ring reference(2000 * sizeof(SealedBlock));
  while (reference.next() < ring.next()) seal_next(reference);
  for (std::int64_t k = backlog.base(); k < backlog.next(); ++k) {
    const SealedBlock* block = backlog.get(k);
    ASSERT_NE(block, nullptr) << k;
    EXPECT_EQ(block->kind, reference.get(k).kind);
    ASSERT_TRUE(std::ranges::equal(block->bytes(), reference.get(k).bytes())) << k;
  }
}

TEST_F(SpoolFolderTest, EverySegmentIsARecordThatDescribesItself) {
  {
    SpoolFolder spool(options, disk);
    Backlog backlog(ring, &spool);
    fill(backlog, 1500);
    disk.kill();
  }
  std::int64_t last = 0;
  int descriptions = 0;
  for (const std::int64_t sequence : sequences_on_disk()) {
    if (sequence == 0) {
      ++descriptions;
      continue;
    }
    EXPECT_EQ(sequence, last + 1);
    last = sequence;
  }
  EXPECT_GT(last, 1300);
  EXPECT_GT(descriptions, 4);
  EXPECT_EQ(descriptions % 2, 0) << "both parts, in each segment";
}

TEST(SpoolFolder, WhatItHoldsOutlivesAPowerCutInFoldersThatAreNew) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SimulatedDisk disk(seed);
    const auto no_warning = [](const std::string&) {};
    ASSERT_TRUE(spools_left("/spools/", no_warning, disk).empty());
    const auto folder = spool_path("/spools/", kNode, kEpoch);
    Ring ring(160 * sizeof(SealedBlock));
    SpoolFolder spool({.folder = folder, .bytes = 4 << 20, .node = kNode, .epoch = kEpoch}, disk);
    for (int k = 1; k <= 100; ++k) seal_next(ring);
    spool.keep(ring, 1, 100, kStart);
    ASSERT_EQ(spool.next(), 101);
    disk.cut_power();
    disk.kill();
    disk.power_on();
    ASSERT_EQ(spools_left("/spools/", no_warning, disk), std::vector<std::filesystem::path>{folder}) << seed;
    RecordReader reader(folder, disk);
    reader.finish();
    std::int64_t blocks = 0;
    while (reader.next()) ++blocks;
    EXPECT_EQ(blocks, 100) << "seed " << seed;
  }
}

TEST_F(SpoolFolderTest, RemovesAFileOnceAllOfItIsGivenBack) {
  SpoolFolder spool(options, disk);
  Backlog backlog(ring, &spool);
  fill(backlog, 1500);
  const std::int64_t half = backlog.next() / 2;
  const std::size_t bytes = bytes_on_disk();
  backlog.free_through(half);
  EXPECT_LT(bytes_on_disk(), bytes * 7 / 10) << "half of the blocks, and one file of 256 KiB more";
  EXPECT_EQ(backlog.base(), half + 1);
  EXPECT_EQ(backlog.get(half + 1)->header.sequence, half + 1);
  backlog.free_through(backlog.next() - 1);
  EXPECT_EQ(disk.list(kFolder.c_str())->size(), 0u);
}

TEST_F(SpoolFolderTest, HoldsNoMoreThanItWasAllowed) {
  SpoolFolder spool(options, disk);
  Backlog backlog(ring, &spool);
  fill(backlog, 100'000);
  EXPECT_EQ(ring.used(), ring.capacity()) << "full: the rest stays in memory, and then nothing fits";
  EXPECT_EQ(backlog.base(), 1) << "the oldest are kept";
  EXPECT_LE(bytes_on_disk(), options.bytes);
  EXPECT_GE(backlog.spooled(), spool.capacity() * 9 / 10);
  EXPECT_EQ(backlog.spool_failures(), 0) << "full is no failure";
  backlog.free_through(1000);
  fill(backlog, ring.next() + 300);
  EXPECT_GT(spool.next(), backlog.base() + 1000);
}

// It takes what is written, then syncs nothing, cuts nothing and removes nothing.
TEST_F(SpoolFolderTest, HoldsNoMoreThanItWasAllowedOfWhatAFailingDiskLeavesBehind) {
  SpoolFolder spool(options, disk);
  Backlog backlog(ring, &spool);
  fill(backlog, 300);
  bool fails = true;
  disk.set_fault([&](DiskCall call, std::int64_t, const std::string&) -> SimulatedDisk::Outcome {
    const bool refused =
        call == DiskCall::kSyncData || call == DiskCall::kTruncate || call == DiskCall::kUnlink;
    return {.error = fails && refused ? EIO : 0};
  });
  for (int second = 0; second < 1000; ++second, now += 1s) fill(backlog, ring.next());
  EXPECT_GT(bytes_on_disk(), options.bytes / 2) << "little was left behind: this test proves nothing";
  EXPECT_LE(bytes_on_disk(), options.bytes);
  fails = false;
  const std::int64_t before = backlog.spooled();
  fill(backlog, ring.next() + 100);
  EXPECT_GT(backlog.spooled(), before) << "what can be removed again makes room";
}

TEST_F(SpoolFolderTest, ADiskThatFailsOnlyLeavesTheBlocksInMemory) {
  SpoolFolder spool(options, disk);
  Backlog backlog(ring, &spool);
  disk.set_fault([](DiskCall call, std::int64_t, const std::string&) {
    return SimulatedDisk::Outcome{.error = call == DiskCall::kSyncData ? EIO : 0};
  });
  fill(backlog, 100'000);
  EXPECT_EQ(backlog.spooled(), 0);
  EXPECT_EQ(ring.used(), ring.capacity());
  EXPECT_GT(backlog.spool_failures(), 0);
  disk.set_fault({});
  now += 2s;
  backlog.relieve(now);
  EXPECT_GT(backlog.spooled(), 0) << "it is tried again";
}

// A node whose recorder calls a little durable now and then; how many calls of the disk that took.
std::int64_t run(SimulatedDisk::Fault fault) {
  SimulatedDisk disk;
  Ring ring(160 * sizeof(SealedBlock));
  SpoolFolder spool({.folder = kFolder, .bytes = 1 << 20, .node = kNode, .epoch = kEpoch}, disk);
  Backlog backlog(ring, &spool);
  disk.set_fault(std::move(fault));
  WallTime now = kStart;
  std::int64_t freed = 0;
  for (int step = 0; step < 500; ++step, now += 20ms) {
    if (ring.used() < ring.capacity()) seal_next(ring);
    backlog.relieve(now);
    if (step % 50 == 49) backlog.free_through(freed += 20);
    EXPECT_EQ(backlog.base(), freed + 1);
  }
  disk.set_fault({});
  for (std::int64_t k = backlog.base(); k < backlog.next(); ++k) {
    const SealedBlock* block = backlog.get(k);
    if (!block) block = backlog.get(k);
    EXPECT_NE(block, nullptr);
    if (block && block->kind == BlockKind::kScan) {
      EXPECT_EQ(decode_scan(*block).counts[3][5], k);
    }
  }
  return disk.calls();
}

// The k-th call fails for every k, in every way: nothing is lost, nothing comes back altered.
TEST_F(SpoolFolderTest, WhateverCallFailsNothingIsLost) {
  const std::int64_t calls = run({});
  ASSERT_GT(calls, 20);
  for (const int error : {EIO, ENOSPC, EROFS, EINTR})
    for (std::int64_t k = 1; k <= calls; ++k) run(SimulatedDisk::at_call(k, {.error = error}));
  for (std::int64_t k = 1; k <= calls; ++k) run(SimulatedDisk::at_call(k, {.error = 0, .short_write = true}));
}

TEST_F(SpoolFolderTest, ABlockThatTheDiskAlteredIsNotGivenBack) {
  SpoolFolder spool(options, disk);
  Backlog backlog(ring, &spool);
  fill(backlog, 200);
  const auto files = disk.list(kFolder.c_str());
  ASSERT_FALSE(files->empty());
  const std::string file = (kFolder / files->front()).string();
  disk.flip_bit(file, disk.content(file).size() * 4);
  int altered = 0;
  SealedBlock block;
  for (std::int64_t k = spool.base(); k < spool.next(); ++k) altered += spool.read(k, block) ? 0 : 1;
  EXPECT_EQ(altered, 1);
}

TEST_F(SpoolFolderTest, NamesWhatAKilledNodeLeftAndNothingOfOneThatLives) {
  std::string warned;
  const auto warn = [&warned](const std::string& text) { warned += text; };
  EXPECT_TRUE(spools_left("/spools", warn, disk).empty());
  options.folder = spool_path("/spools", kNode, kEpoch);
  SpoolFolder spool(options, disk);
  Backlog backlog(ring, &spool);
  fill(backlog, 200);
  EXPECT_TRUE(spools_left("/spools", warn, disk).empty());
  disk.kill();
  EXPECT_EQ(spools_left("/spools", warn, disk),
            std::vector<std::filesystem::path>{"/spools/node-3-000000000000004d"});
  EXPECT_EQ(warned, "");
}

TEST(SpoolFolder, PassesByWhatIsNoFolderOfANode) {
  const test::TemporaryDirectory work;
  std::ofstream(work.path() / "node-notes") << "of somebody";
  std::string warned;
  const auto warn = [&warned](const std::string& text) { warned += text; };
  EXPECT_TRUE(spools_left(work.path(), warn).empty());
  EXPECT_NE(warned.find("not looked into: open " + (work.path() / "node-notes").string()), std::string::npos)
      << warned;
}

TEST(SpoolFolder, NamesAFolderThatCannotBeMade) {
  SimulatedDisk disk;
  disk.set_read_only(true);
  try {
    SpoolFolder spool({.folder = "/spool", .bytes = 4 << 20, .node = 1, .epoch = 1}, disk);
    FAIL() << "accepted";
  } catch (const std::system_error& error) {
    EXPECT_NE(std::string(error.what()).find("/spool"), std::string::npos) << error.what();
  }
  SimulatedDisk good;
  EXPECT_THROW(SpoolFolder({.folder = "/spool", .bytes = 1000, .node = 1, .epoch = 1}, good),
               std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
