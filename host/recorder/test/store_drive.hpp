#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/record/test/numbered_blocks.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "host/recorder/recording_store.hpp"

namespace roadbalance::test {

using std::chrono::milliseconds;
using Outcome = SimulatedDisk::Outcome;

inline constexpr const char* kFolder = "/record";

/// A store on a disk of its own, fed with blocks.
class Drive {
 public:
  explicit Drive(std::uint64_t seed = 3) : disk(seed) {}

  RecordingStore& start() {
    store.emplace(disk, options);
    store->set_clocks(1'790'000'000'000'000, 1);
    store->begin();
    return *store;
  }

  // Time passes; so many blocks come, evenly, and what is due is done.
  void run(milliseconds duration, int blocks = 0) {
    const std::int64_t first = given;
    constexpr milliseconds kStep{10};
    for (milliseconds t{0}; t < duration; t += kStep) {
      now += kStep;
      while (given < first + blocks * (t + kStep) / duration)
        store->append(Delivery(numbered_block(++given)), now);
      if (store->commit_is_due(now))
        note_durable(store->commit(now));
      else
        store->maintain();
    }
  }
  void note_durable(const std::vector<DurableMark>& marks) {
    for (const auto& mark : marks) {
      EXPECT_GT(mark.sequence, durable);
      durable = mark.sequence;
    }
  }
  // Numbers of the blocks in the record, in its order, each with the bytes it was given.
  std::vector<std::int64_t> recorded(const char* folder = kFolder) {
    std::vector<std::int64_t> found;
    RecordReader reader(folder, disk);
    reader.finish();
    SealedBlock block;
    while (const auto event = reader.next()) {
      if (accept(event->data, block) != Refusal::kNone || block.header.sequence == 0) continue;
      EXPECT_TRUE(std::ranges::equal(numbered_block(block.header.sequence).bytes(), event->data));
      found.push_back(block.header.sequence);
    }
    return found;
  }
  std::vector<Note> notes(NoteKind kind, const char* folder = kFolder) {
    std::vector<Note> found;
    RecordReader reader(folder, disk);
    reader.finish();
    while (const auto event = reader.next())
      if (const auto note = event->channel == kNoteChannel ? decode_note(event->data) : std::nullopt)
        if (note->kind == kind) found.push_back(*note);
    return found;
  }
  bool was_warned_of(const std::string& words) {
    bool found = false;
    for (const auto& warning : store->warnings()) found = found || warning.find(words) != std::string::npos;
    return found;
  }
  // Calls of these kinds fail from now on; with a folder, those in it.
  void fail(std::vector<DiskCall> kinds, int error, const std::string& folder = "") {
    disk.set_fault([kinds, error, folder](DiskCall call, std::int64_t, const std::string& path) {
      const bool fails = std::ranges::find(kinds, call) != kinds.end() && path.starts_with(folder);
      return Outcome{.error = fails ? error : 0};
    });
  }
  void fail_nothing() { disk.set_fault(nullptr); }
  void fail_syncs(int error) { fail({DiskCall::kSyncData, DiskCall::kSync}, error); }

  SimulatedDisk disk;
  StoreOptions options{.folder = kFolder, .segment_bytes = 64 << 10};
  std::optional<RecordingStore> store;
  WallTime now = WallTime(std::chrono::hours(1));
  std::int64_t given = 0;
  std::int64_t durable = 0;
};

}  // namespace roadbalance::test
