#pragma once

#include <cstdint>
#include <filesystem>
#include <map>

#include "common/record/disk.hpp"

namespace roadbalance {

/// How far a segment can be believed that was being written when its writer was killed or the power went.
struct SegmentExtent {
  std::uint64_t end = 0;  ///< the events before are good; what follows is torn
  std::uint64_t durable =
      0;  ///< so much was on the disk at the last commit event: damage before is no torn tail
  std::uint64_t commit_at = 0;  ///< offset of that event
  std::uint64_t size = 0;       ///< of the file
};
SegmentExtent measure_segment(const std::filesystem::path& segment, Disk& disk = kernel_disk());

/// Where segments before this one end, if they were abandoned: by segment.  The notes of that are the first
/// events of the segment begun next.
std::map<int, std::uint64_t> abandoned_before(const std::filesystem::path& segment,
                                              Disk& disk = kernel_disk());

}  // namespace roadbalance
