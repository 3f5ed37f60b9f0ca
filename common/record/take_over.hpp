#pragma once

#include <filesystem>
#include <optional>

#include "common/record/file.hpp"
#include "common/record/record_writer.hpp"

namespace roadbalance {

/// The state of a folder that a writer continues.
struct TakenOver {
  int segment = 0;  ///< number of the last segment, 0 if there is none
  std::optional<RecordWriter::CutTail> cut;
  RecordState holds;
};

/// Makes a folder fit to be continued: takes away segments without any event and segments that never got
/// their name, cuts the torn tail of the last one and keeps it beside, makes durable what its writer may have
/// left to the page cache, and completes the indexes.
///
/// If the last segment has no index, only its part before its last commit event is certain to be on the disk.
/// The events that follow may have been promised all the same, for the commit event of a sync comes with the
/// next append; or their sync may have failed, which is not reported again.  They are written again and
/// synced.
/// @param folder  open and locked
/// @throws std::system_error naming the file
TakenOver take_over(File& folder, RecordState before, Disk& disk);

}  // namespace roadbalance
