#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "common/record/disk.hpp"
#include "host/recording/manifest.hpp"

namespace roadbalance {

/// Consecutive segments.
struct SegmentRun {
  int first = 0;
  int last = 0;
};
/// "segment 3", "segments 1 to 3"
std::string in_words(SegmentRun run);

/// Segments that are missing without any event of the record showing it.
struct MissingSegments {
  std::int64_t missing = 0;  ///< segments absent, empty or shorter than when they were finished
  std::vector<std::string>
      lines;  ///< which, for people; also one that a kill left empty, which is not missing
  /// Segments before the first one here that the retention mode deleted.  The notes on the first of them went
  /// with their segments; but a segment that the manifest lists had not been deleted.
  std::vector<SegmentRun> deleted;
};

/// Compares the segments with the manifest and the indexes beside them, which are written when one is
/// finished.
/// @param finished  of the manifest
/// @param deleted  numbers of segments that the retention mode deleted, by the notes that are left
/// @throws std::system_error naming the file
MissingSegments find_missing_segments(const std::filesystem::path& folder, const FinishedSegments& finished,
                                      const std::set<int>& deleted, Disk& disk = kernel_disk());

}  // namespace roadbalance
