#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/record/disk.hpp"

namespace roadbalance {

/// In a recording's folder, from its first start on: the numbers that its recorders have had, one a line,
/// rising.  By these, and only these, a node decides whether it obeys this recording.
inline constexpr const char* kIncarnationFile = "incarnation";

struct Incarnation {
  std::int64_t number = 0;
  std::filesystem::path folder = {};  ///< that it is stored in
};

/// All of them, the latest 1024; empty: there is no file.
/// @throws std::system_error naming the file, std::runtime_error if its content is not numbers
std::vector<std::int64_t> stored_incarnations(const std::filesystem::path& folder,
                                              Disk& disk = kernel_disk());

/// The highest of them; 0 if there is none.
/// @throws std::system_error naming the file, std::runtime_error if its content is not numbers
std::int64_t stored_incarnation(const std::filesystem::path& folder, Disk& disk = kernel_disk());

/// The recorder's number in this run: higher than in every earlier run on the folder, and, by the wall clock,
/// than that of earlier recordings.  On the disk before it is returned.
/// @param least  the wall clock, in ms since 1970
/// @throws std::system_error naming the file, std::runtime_error if its content is not numbers
std::int64_t next_incarnation(const std::filesystem::path& folder, std::int64_t least,
                              Disk& disk = kernel_disk());

/// Adds it to them, also in a folder that was made again.  @throws std::system_error naming the file
void keep_incarnation(const std::filesystem::path& folder, std::int64_t number, Disk& disk = kernel_disk());

/// For a node that obeyed a higher number (the wall clock was set back): one above `obeyed`, on the disk.
/// @throws std::system_error naming the file, also if there is none: its disk may be unmounted
std::int64_t raise_incarnation(const std::filesystem::path& folder, std::int64_t obeyed,
                               Disk& disk = kernel_disk());

}  // namespace roadbalance
