#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "common/record/disk.hpp"
#include "common/record/record_reader.hpp"

namespace roadbalance {

/// Writes manifest.json: the finished segments and their sizes, for people, for transfer, and so that a
/// shortened one is noticed.  A segment keeps the size it was first listed with: a finished one does not
/// change.  The manifest is never trusted over the segments, and a record is complete without it.
/// @param last  number of the last finished segment; default: all are
/// @param without  numbers of segments that are deleted: not listed
/// @throws std::system_error naming the file
void write_manifest(const std::filesystem::path& folder, std::optional<int> last = std::nullopt,
                    Disk& disk = kernel_disk(), const std::set<int>& without = {});

using FinishedSegments = std::map<std::string, std::uint64_t>;  ///< size by file name

/// The finished segments; empty if there is no manifest or it is damaged.
FinishedSegments read_manifest(const std::filesystem::path& folder, Disk& disk = kernel_disk());

/// There is a manifest file, but its content is none.
bool is_manifest_damaged(const std::filesystem::path& folder, Disk& disk = kernel_disk());

/// Bytes that a kill or a power cut tore off were never promised and are no damage, except in a finished
/// segment.
bool is_torn_tail(const RecordReader::Damage& damage, const FinishedSegments& finished);

/// Damaged bytes of a recording that was read to its end; a torn tail does not count.
std::uint64_t damaged_bytes(const std::filesystem::path& folder, const RecordReader& reader);

}  // namespace roadbalance
