#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/record/disk.hpp"

namespace roadbalance {

/// The findings of recover().
struct Recovered {
  std::int64_t blocks = 0;            ///< of nodes, written
  std::int64_t blocks_filled = 0;     ///< of them: taken from behind the place where they were missing
  std::int64_t gaps = 0;              ///< declared for missing blocks, written
  std::int64_t blocks_repeated = 0;   ///< found more than once, written once
  std::int64_t blocks_altered = 0;    ///< good events on a block's channel that hold no good block
  std::int64_t entries_altered = 0;   ///< the same of notes, clocks, journal and commits
  std::int64_t headers_altered = 0;   ///< stretches with an altered event that its own CRC does not show
  std::int64_t missing_segments = 0;  ///< absent, empty or shorter than when they were finished
  std::uint64_t damaged_bytes = 0;    ///< bytes that are no events
  std::vector<std::string> damage;    ///< where, for people
  std::vector<std::string> lost;      ///< losses that no gap stands for, for people
};

/// Makes a good record of all good blocks in one or more folders, which it only reads: a damaged record
/// first, then sources that may fill its holes: spools that nodes left, the record in a fallback folder.
///
/// Each event stands for itself: after damage reading goes on at the next sync word where both the event and
/// the block pass their checks.  Cut tails and abandoned segments are read, too.  In the new record every
/// node epoch is in order, each block once and as it was sealed; each hole is a declared gap, with the cause
/// that the recorder gave it (kLostAtNode), else kLostInRecord.  Clocks and notes are copied; the journal is
/// new. Damaged bytes, other than the tail of a kill or a power cut, may have held anything, and so may a
/// folder that the sources name (find_elsewhere()) and that is not among them: a note in the new record
/// declares the loss (tells_of_loss()), and `rb verify` calls the record incomplete.
///
/// Memory: some tens of bytes for each block that is out of place.
/// @param target  a folder that does not exist or is empty
/// @throws std::runtime_error if no block is found, std::system_error naming the file
Recovered recover(const std::vector<std::filesystem::path>& sources, const std::filesystem::path& target,
                  Disk& disk = kernel_disk());

}  // namespace roadbalance
