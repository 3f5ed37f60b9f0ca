#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/link/epoch_receiver.hpp"
#include "common/record/disk.hpp"
#include "common/record/recorded_clocks.hpp"
#include "common/types/blocks.hpp"

namespace roadbalance {

/// The contents of a record, as far as a recorder needs them to continue it.
struct RecordState {
  struct Epoch {
    EpochPosition position;
    std::int64_t samples = 0;
    std::int64_t gaps = 0;
    std::int64_t blocks = 0;
    /// Over the blocks before the end; nothing once one is not the node's own, or if the end carries another.
    std::optional<std::uint32_t> sum = 0;

    bool operator==(const Epoch& other) const {
      return position.contiguous == other.position.contiguous &&
             position.next_scan == other.position.next_scan && position.ended == other.position.ended &&
             position.crashed == other.position.crashed && samples == other.samples && gaps == other.gaps &&
             blocks == other.blocks && sum == other.sum;
    }
  };
  std::map<NodeEpoch, Epoch> epoch;
  /// The parts of vehicle.toml of each epoch; of those that have ended only while there is room.
  using Descriptions = std::map<NodeEpoch, std::vector<SealedBlock>>;
  Descriptions vehicle;
  RecordedClocks clocks;
};

/// The notes that the next segment repeats: those of epochs that have not ended.  One that is longer, or one
/// more than there is room for in all, stands in the record where it came, but is not repeated.
RecordState::Descriptions going_on(const RecordState& state);
inline constexpr std::int32_t kMostDescriptionParts = 64;        ///< of an epoch: 75 kB of text
inline constexpr std::size_t kMostDescriptionPartsInAll = 1024;  ///< 1.4 MB in each segment

/// Adds the next block of the record; one that is there already counts for nothing, and a description
/// (sequence 0) only adds to `vehicle`.
///
/// Blocks behind a hole, or behind a beginning that is in another folder or deleted, are in the record all
/// the same: recorders write every epoch in sequence, so that the missing ones were taken, called durable and
/// lost here.  Their node does not have them any more, and a recorder that asked it to begin again before the
/// hole would declare lost what is there.
void add(const SealedBlock& block, RecordState& state);

/// The part of the clocks that the next segment repeats: that of epochs that have not ended.
RecordEvents clocks_going_on(const RecordState& state);

/// A block that can be read and that a power cut may take: see read_state().
struct UnsureBlock {
  SealedBlock block;
  std::int64_t timestamp_us = 0;
};

/// Reads a record that no program writes to, and changes nothing: the segments behind the last one with a
/// good index.  Empty if there is no such folder, or no segment in it.
///
/// Counts what is known to be on the disk.  Behind the last commit event of a last segment without an index
/// lies what may have been promised already, or have been left to the page cache by a sync that failed: only
/// who writes it again may count it.
/// @param before  what it continues: another folder's record; its clocks count if this one has no segment
/// @param unsure  gets those blocks, in order, if given
RecordState read_state(const std::filesystem::path& folder, Disk& disk = kernel_disk(),
                       RecordState before = {}, std::vector<UnsureBlock>* unsure = nullptr);

/// Whether a folder holds all of a record that was written there, what may have been promised included.
/// @param record  as it stood when it was written, as far as it was durable
/// @param before  what it continues: the record of another folder
bool holds_all_of(const RecordState& record, const std::filesystem::path& folder, RecordState before,
                  Disk& disk = kernel_disk());

/// Called at the end of each segment that is read, with the state there.
using AtSegmentEnd = std::function<void(int segment, const RecordState& state)>;
/// As read_state(), from segment `first` on, which continues `state` but for the clocks.
void read_segments(const std::filesystem::path& folder, int first, RecordState& state,
                   const AtSegmentEnd& at_end, Disk& disk = kernel_disk());

}  // namespace roadbalance
