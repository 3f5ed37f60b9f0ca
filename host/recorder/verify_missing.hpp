#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "common/record/disk.hpp"
#include "host/recorder/manifest.hpp"

namespace roadbalance {

/// Consecutive segments.
struct SegmentRun {
  int first = 0;
  int last = 0;
};
/// "segment 3", "segments 1 to 3"
std::string in_words(SegmentRun run);

/// What no event of a record tells of.
struct MissingSegments {
  std::int64_t missing = 0;  ///< segments not there, empty or not as long as when they were finished
  std::vector<std::string>
      lines;  ///< which, for people; also of one that a kill left empty, which is not missing
  /// Those before the first one here that the retention mode took.  The notes on the first of them went with
  /// their segments; but what the manifest lists had not been taken.
  std::vector<SegmentRun> deleted;
};

/// Held against the manifest and the indexes beside the segments, which are written when one is finished.
/// @param finished  of the manifest
/// @param deleted  numbers of segments that the retention mode took away, by the notes that are left
/// @throws std::system_error naming the file
MissingSegments find_missing_segments(const std::filesystem::path& folder, const FinishedSegments& finished,
                                      const std::set<int>& deleted, Disk& disk = kernel_disk());

}  // namespace roadbalance
