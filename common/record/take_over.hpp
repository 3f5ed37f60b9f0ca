#pragma once

#include <filesystem>
#include <optional>

#include "common/record/file.hpp"
#include "common/record/record.hpp"

namespace roadbalance {

/// What a writer finds in a folder that it continues.
struct TakenOver {
  int segment = 0;  ///< number of the last segment, 0 if there is none
  std::optional<RecordWriter::CutTail> cut;
  RecordState holds;
};

/// Makes a folder fit to be continued: takes away segments without any event and segments that never got
/// their name, cuts the torn tail of the last one and keeps it beside, makes durable what its writer may have
/// left to the page cache, and completes the indexes.
///
/// Of the last segment, if it has no index, only what lies before its last commit event is known to be on the
/// disk.  What follows may have been promised all the same, for the commit event of a sync comes with the
/// next append; or its sync may have failed, which nobody is told again.  It is written again and synced.
/// @param folder  open and locked
/// @throws std::system_error naming the file
TakenOver take_over(File& folder, RecordState before, Disk& disk);

}  // namespace roadbalance
