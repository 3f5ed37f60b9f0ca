#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/record/disk.hpp"

namespace roadbalance {

/// What salvage() found.
struct Salvaged {
  std::int64_t blocks = 0;            ///< of nodes, written
  std::int64_t blocks_filled = 0;     ///< of them: from a place behind the one where they were missing
  std::int64_t gaps = 0;              ///< declared for what is not there, written
  std::int64_t blocks_repeated = 0;   ///< found more than once, written once
  std::int64_t blocks_altered = 0;    ///< good events on a block's channel, but no good block
  std::int64_t entries_altered = 0;   ///< the same of notes, clocks, journal and commits
  std::int64_t headers_altered = 0;   ///< stretches with an altered number, stamp or channel
  std::int64_t missing_segments = 0;  ///< not there, empty or not as long as when they were finished
  std::uint64_t damaged_bytes = 0;    ///< no events
  std::vector<std::string> damage;    ///< where, for people
  std::vector<std::string> lost;      ///< that no gap stands for, for people
};

/// Makes a good record of all good blocks in one or more folders, which it only reads: a damaged record
/// first, then what may fill its holes: spools that nodes left, the record in a fallback folder.
///
/// Each event stands for itself: after damage it goes on at the next sync word where both the event and the
/// block pass their checks.  Tails that were cut and segments that were abandoned are read too.  In the new
/// record every node epoch is in order, each block once and as it was sealed; each hole is a declared gap: of
/// the cause that the recorder gave it (kLostAtNode), else kLostInRecord.  Clocks and notes go along, and a
/// new journal.  What was damaged, but for what a kill or a power cut leaves at the end, may have held
/// anything, and so may a folder that the sources name (find_elsewhere()) and that is none of them: a note in
/// the new record says so (tells_of_loss()), and `rb verify` calls it incomplete.
///
/// Memory: some tens of bytes for each block that is not where it belongs.
/// @param target  a folder that does not exist or is empty
/// @throws std::runtime_error if no block is found, std::system_error naming the file
Salvaged salvage(const std::vector<std::filesystem::path>& sources, const std::filesystem::path& target,
                 Disk& disk = kernel_disk());

}  // namespace roadbalance
