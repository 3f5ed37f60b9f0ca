#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/record/disk.hpp"
#include "host/recorder/manifest.hpp"

namespace roadbalance {

/// What no event of a record tells of.
struct MissingSegments {
  std::int64_t missing = 0;  ///< segments not there, empty or not as long as when they were finished
  std::vector<std::string>
      lines;  ///< which, for people; also of one that a kill left empty, which is not missing
};

/// Held against the manifest and the indexes beside the segments, which are written when one is finished.
/// @param finished  of the manifest
/// @param deleted_through  number of the last segment that the retention mode took away, as the notes say
/// @throws std::system_error naming the file
MissingSegments find_missing_segments(const std::filesystem::path& folder, const FinishedSegments& finished,
                                      int deleted_through, Disk& disk = kernel_disk());

/// Which other folders have what came before, or what comes behind, as its files say; for people.
std::vector<std::string> find_elsewhere(const std::filesystem::path& folder, Disk& disk = kernel_disk());

}  // namespace roadbalance
