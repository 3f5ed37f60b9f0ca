#pragma once

#include <cstdint>
#include <filesystem>

#include "common/record/file.hpp"

namespace roadbalance {

/// Makes durable what another process wrote, whose syncs are unknown.
///
/// A sync that failed is reported once, to the file that was open then, and its pages count as clean from
/// there on: a later sync of them returns success and does nothing.  So the bytes are given to the disk once
/// more, in place and as they are, and then synced; a power cut meanwhile leaves each sector with the one
/// content or with the same again.
/// @param file  open for writing
/// @param from  what lies before is known to be durable
/// @throws std::system_error naming the file
void write_again(File& file, std::uint64_t from, Disk& disk);

}  // namespace roadbalance
