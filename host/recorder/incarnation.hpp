#pragma once

#include <cstdint>
#include <filesystem>

namespace roadbalance {

/// The recorder's number in this run: higher than in every earlier run on the folder, and, by the wall clock,
/// than that of earlier recordings.  On the disk before it is returned.
/// @throws std::system_error naming the file, std::runtime_error if its content is not a number
std::int64_t next_incarnation(const std::filesystem::path& folder);

/// For a node that obeyed a higher number (the wall clock was set back): one above `obeyed`, on the disk.
std::int64_t raise_incarnation(const std::filesystem::path& folder, std::int64_t obeyed);

}  // namespace roadbalance
