#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "common/link/epoch_receiver.hpp"
#include "common/record/disk.hpp"

namespace roadbalance {

using NodeEpoch = std::pair<std::int32_t, std::int64_t>;

/// What a recording folder already holds, for a recorder that continues it.
struct Recovered {
  struct Epoch {
    EpochPosition position;
    std::int64_t samples = 0;
    std::int64_t gaps = 0;
    std::int64_t blocks = 0;
  };
  std::map<NodeEpoch, Epoch> epoch;
  std::map<NodeEpoch, std::vector<SealedBlock>> vehicle;  ///< the parts of vehicle.toml of each epoch
};

/// Reads the whole record; nothing if the folder does not exist or holds no segment.
Recovered recover_record(const std::filesystem::path& folder, Disk& disk = kernel_disk());

}  // namespace roadbalance
