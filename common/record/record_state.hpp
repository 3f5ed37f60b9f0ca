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

namespace roadbalance {

using NodeEpoch = std::pair<std::int32_t, std::int64_t>;

/// What a record holds, as far as a recorder must know to continue it.
struct RecordState {
  struct Epoch {
    EpochPosition position;
    std::int64_t samples = 0;
    std::int64_t gaps = 0;
    std::int64_t blocks = 0;

    bool operator==(const Epoch& other) const {
      return position.contiguous == other.position.contiguous &&
             position.next_scan == other.position.next_scan && position.ended == other.position.ended &&
             position.crashed == other.position.crashed && samples == other.samples && gaps == other.gaps &&
             blocks == other.blocks;
    }
  };
  std::map<NodeEpoch, Epoch> epoch;
  std::map<NodeEpoch, std::vector<SealedBlock>> vehicle;  ///< the parts of vehicle.toml of each epoch
};

/// Adds the next block of the record.  One that does not continue its epoch counts for nothing; a description
/// (sequence 0) only adds to `vehicle`.
void add(const SealedBlock& block, RecordState& state);

/// Reads a record that nobody writes to: the segments behind the last one with a good index.  Empty if there
/// is no such folder, or no segment in it.
/// @param before  what it continues: the record of another folder
RecordState read_state(const std::filesystem::path& folder, Disk& disk = kernel_disk(),
                       RecordState before = {});

/// Told at the end of each segment that is read, with the state there.
using AtSegmentEnd = std::function<void(int segment, const RecordState& state)>;
/// As read_state(), from segment `first` on, which continues `state`.
void read_segments(const std::filesystem::path& folder, int first, RecordState& state,
                   const AtSegmentEnd& at_end, Disk& disk = kernel_disk());

}  // namespace roadbalance
