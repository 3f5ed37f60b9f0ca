#pragma once

#include "common/record/file.hpp"
#include "common/record/segment_index.hpp"

namespace roadbalance {

/// A segment all of which is on the disk, and that nothing is added to any more.  The remaining work takes
/// nothing from it when it does not happen: a start without it only takes longer.
struct WrittenSegment {
  File file;
  SegmentIndex index;  ///< where the record stands at its end

  /// Gives back the space reserved behind its end, closes it, and writes its index.
  /// @throws std::system_error naming the segment; an index that cannot be written is no failure
  void finish(const std::filesystem::path& folder, Disk& disk);
};

/// Cuts a segment that failed to what is on the disk, or removes it if that is nothing: an empty last one
/// would look as if its recorder had been killed.  A disk that does not let us is no failure: the next
/// segment notes where this one ends.  But the space that was reserved behind it is taken until it is cut.
/// @return whether the disk did it
bool cut_back(File segment, std::uint64_t durable_bytes, const std::filesystem::path& path, Disk& disk);

}  // namespace roadbalance
