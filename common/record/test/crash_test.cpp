#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>

#include "common/record/folder.hpp"
#include "common/record/segment.hpp"
#include "common/record/test/numbered_blocks.hpp"
#include "common/record/test/simulated_disk.hpp"

namespace roadbalance::test {
namespace {

const std::filesystem::path kFolder = "/drives/one";
constexpr std::uint64_t kSegmentBytes = 16 << 10;

// RB_CRASHES power cuts that tear a sector, of which the acceptance takes 100 000.
int crashes() {
  const char* given = std::getenv("RB_CRASHES");
  return given ? std::atoi(given) : 1000;
}

// At one of the next calls that write or sync: between them nothing is on its way to the platter.
SimulatedDisk::Fault power_cut_while_writing(std::mt19937_64& random) {
  return [left = random() % 60](DiskCall call, std::int64_t,
                                const std::string&) mutable -> SimulatedDisk::Outcome {
    const bool writes = call == DiskCall::kWrite || call == DiskCall::kSyncData || call == DiskCall::kSync;
    return {.power_cut = writes && left-- == 0};
  };
}

// All damage is torn tails.  How many bytes of which segment.
std::map<std::filesystem::path, std::uint64_t> listed_torn(const FoundBlocks& found) {
  std::map<std::filesystem::path, std::uint64_t> bytes;
  for (const auto& piece : found.damage) {
    EXPECT_TRUE(piece.torn) << piece.segment << " at " << piece.offset << ": " << piece.what;
    bytes[piece.segment] += piece.bytes;
  }
  return bytes;
}

// Each byte of a segment is in an event or in the damage listed: nothing is passed over.  Returns how many
// are listed.
std::uint64_t expect_each_byte_accounted_for(const FoundBlocks& found, SimulatedDisk& disk) {
  auto torn = listed_torn(found);
  std::uint64_t all = 0;
  if (!path_exists(kFolder, disk)) return all;
  for (const int number : segment_numbers(kFolder, disk)) {
    const auto segment = segment_path(kFolder, number);
    const auto events = found.event_bytes.find(number);
    EXPECT_EQ(torn[segment] + (events == found.event_bytes.end() ? 0 : events->second),
              disk.content(segment.string()).size())
        << segment;
    all += torn[segment];
  }
  return all;
}

// Conditions on a record after a power cut, before it is touched.
void expect_nothing_lost(SimulatedDisk& disk, std::int64_t durable, FoundBlocks& found) {
  found = {};
  if (durable == 0 && (!path_exists(kFolder, disk) || segment_numbers(kFolder, disk).empty())) return;
  found = find_blocks(kFolder, disk);
  EXPECT_EQ(found.false_blocks, 0);
  EXPECT_TRUE(found.altered.empty());
  ASSERT_GE(static_cast<std::int64_t>(found.sequences.size()), durable);
  ASSERT_EQ(found.sequences, all_through(static_cast<std::int64_t>(found.sequences.size())));
}

// One life of a recorder on this disk: until the power goes, or it is killed, or it has all blocks.
std::int64_t live(SimulatedDisk& disk, std::mt19937_64& random, std::int64_t durable, std::int64_t last) {
  std::optional<Feeder> feeder;
  try {
    feeder.emplace(RecordWriter::Options{.folder = kFolder, .segment_bytes = kSegmentBytes}, disk);
  } catch (const std::system_error&) {
    return durable;  // the power went
  }
  EXPECT_GE(feeder->found(), durable);
  durable = std::max(durable, feeder->found());
  while (feeder->appended() < last) {
    const auto more = static_cast<std::int64_t>(random() % 12);
    if (!feeder->append_through(std::min(last, feeder->appended() + more))) break;
    if (random() % 3 != 0 && !feeder->sync()) break;
    if (random() % 3 == 0) (void)feeder->writer().tidy();
    if (random() % 400 == 0) break;  // killed
    durable = std::max(durable, feeder->durable());
  }
  durable = std::max(durable, feeder->durable());
  disk.kill();
  return durable;
}

TEST(Crash, APowerCutAtAnyMomentLosesNothingThatWasCalledDurable) {
  const int wanted = crashes();
  std::uint64_t torn_bytes = 0;
  int cuts = 0, torn = 0;
  for (std::uint64_t seed = 1; torn < wanted; ++seed) {
    SimulatedDisk disk(seed);
    std::mt19937_64 random(seed);
    std::int64_t durable = 0, last = 0;
    for (int life = 0; life < 6 && torn < wanted; ++life) {
      const std::int64_t torn_before = disk.torn_sectors();
      disk.set_fault(power_cut_while_writing(random));
      durable = live(disk, random, durable, last += 100);
      if (!disk.is_off()) disk.cut_power();
      ++cuts;
      torn += disk.torn_sectors() > torn_before ? 1 : 0;
      disk.power_on();
      disk.set_fault(nullptr);
      FoundBlocks found;
      ASSERT_NO_FATAL_FAILURE(expect_nothing_lost(disk, durable, found))
          << "seed " << seed << " life " << life;
      torn_bytes += expect_each_byte_accounted_for(found, disk);
      ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed << " life " << life;
    }
    Feeder feeder({.folder = kFolder, .segment_bytes = kSegmentBytes}, disk);
    ASSERT_TRUE(feeder.append_through(last + 10) && feeder.close());
    const FoundBlocks found = find_blocks(kFolder, disk);
    ASSERT_EQ(found.sequences, all_through(last + 10)) << "seed " << seed;
    ASSERT_TRUE(found.damage.empty()) << "seed " << seed;
  }
  EXPECT_GT(torn_bytes, 0u) << "no record ended in a torn tail: this test proves nothing";
  std::printf("%d power cuts, of which %d tore sectors, of %llu bytes of torn tails\n", cuts, torn,
              static_cast<unsigned long long>(torn_bytes));
}

// A drive with several segments, a kill and a restart, on a disk that fails once.
void drive_on(SimulatedDisk& disk, std::int64_t& durable) {
  for (const std::int64_t last : {25, 60}) {
    std::optional<Feeder> feeder;
    for (int tries = 0; !feeder && tries < 3 && !disk.is_off(); ++tries) try {
        feeder.emplace(RecordWriter::Options{.folder = kFolder, .segment_bytes = kSegmentBytes}, disk);
      } catch (const std::system_error&) {
        disk.kill();  // the program ends, and is started again
      }
    if (!feeder) return;
    durable = std::max(durable, feeder->found());
    for (std::int64_t next = feeder->found(); next < last; next += 4) {
      if (!feeder->append_through(std::min(next + 4, last))) return;
      if (!feeder->sync()) return;
      durable = std::max(durable, feeder->durable());
      if (last == 25) (void)feeder->writer().tidy();  // else a rotation does it
    }
    if (last == 60) feeder->close();
    durable = std::max(durable, feeder->durable());
    disk.kill();
  }
}

TEST(Crash, WhicheverCallFailsNothingIsCalledDurableThatIsNot) {
  SimulatedDisk smooth;
  std::int64_t all = 0;
  drive_on(smooth, all);
  ASSERT_EQ(all, 60);
  const std::int64_t calls = smooth.calls();
  ASSERT_GT(calls, 100);

  using Outcome = SimulatedDisk::Outcome;
  for (const Outcome outcome :
       {Outcome{.error = EIO}, Outcome{.error = ENOSPC}, Outcome{.error = EROFS}, Outcome{.error = EINTR},
        Outcome{.short_write = true}, Outcome{.power_cut = true}})
    for (std::int64_t k = 1; k <= calls; ++k) {
      SimulatedDisk disk(static_cast<std::uint64_t>(k));
      disk.set_fault(SimulatedDisk::at_call(k, outcome));
      std::int64_t durable = 0;
      drive_on(disk, durable);
      const std::string what = "call " + std::to_string(k) + " errno " + std::to_string(outcome.error);
      if (!outcome.power_cut) {
        ASSERT_EQ(durable, 60) << what << ": one failure was too much";
      }
      if (!disk.is_off()) disk.cut_power();
      disk.power_on();
      FoundBlocks found;
      ASSERT_NO_FATAL_FAILURE(expect_nothing_lost(disk, durable, found)) << what;
      listed_torn(found);
      ASSERT_FALSE(::testing::Test::HasFailure()) << what;
    }
}

// From one call on everything fails, then the disk is well again: the recorder never ended.
TEST(Crash, ADiskThatFailsForAWhileLosesNothing) {
  for (const int error : {EIO, ENOSPC, EROFS})
    for (std::int64_t from = 20; from < 120; ++from) {
      SimulatedDisk disk(static_cast<std::uint64_t>(from));
      Feeder feeder({.folder = kFolder, .segment_bytes = kSegmentBytes}, disk);
      bool failing = true;
      disk.set_fault([&](DiskCall, std::int64_t number, const std::string&) -> SimulatedDisk::Outcome {
        return {.error = failing && number >= from ? error : 0};
      });
      for (std::int64_t next = 4; next <= 80; next += 4)
        if (!feeder.append_through(next) || !feeder.sync()) failing = false;
      EXPECT_FALSE(failing);
      ASSERT_TRUE(feeder.append_through(80) && feeder.sync());
      disk.cut_power();
      disk.power_on();
      disk.set_fault(nullptr);
      const FoundBlocks found = find_blocks(kFolder, disk);
      ASSERT_EQ(found.sequences, all_through(80)) << "errno " << error << " from call " << from;
      listed_torn(found);
      ASSERT_FALSE(::testing::Test::HasFailure()) << "errno " << error << " from call " << from;
    }
}

// A network's disk loses the answer to a rename that it has done.
TEST(Crash, ARenameThatHappenedThoughItFailedIsGoneOnFrom) {
  SimulatedDisk disk;
  Feeder feeder({.folder = kFolder, .segment_bytes = kSegmentBytes}, disk);
  ASSERT_TRUE(feeder.append_through(4) && feeder.sync());
  const int before = feeder.writer().segment();
  const std::string unnamed = segment_path(kFolder, before + 1).string() + ".new";
  int failures = 0;
  disk.set_fault([&](DiskCall call, std::int64_t, const std::string& path) -> SimulatedDisk::Outcome {
    if (call != DiskCall::kRename || path != unnamed || failures > 0) return {};
    ++failures;
    disk.put(segment_path(kFolder, before + 1), disk.content(unnamed));
    return {.error = EIO};
  });
  for (std::int64_t next = 5; failures == 0; ++next) ASSERT_TRUE(feeder.append_through(next));
  feeder.writer().let_go({});
  ASSERT_TRUE(feeder.append_through(80) && feeder.close());
  EXPECT_EQ(find_blocks(kFolder, disk).sequences, all_through(80));
}

TEST(Crash, RotationsAreSampleExact) {
  SimulatedDisk disk;
  constexpr std::int64_t kBlocks = 3000;
  Feeder feeder({.folder = kFolder, .segment_bytes = 3000}, disk);
  ASSERT_TRUE(feeder.append_through(kBlocks) && feeder.close());
  EXPECT_GE(segment_numbers(kFolder, disk).size(), 1000u);
  const FoundBlocks found = find_blocks(kFolder, disk);
  EXPECT_EQ(found.sequences, all_through(kBlocks));
  EXPECT_TRUE(found.damage.empty());
}

}  // namespace
}  // namespace roadbalance::test
