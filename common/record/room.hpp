#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/record/disk.hpp"

namespace roadbalance {

/// "9.3 GB", "41.0 MB".
std::string bytes_text(std::uint64_t bytes);

/// To be asked before work that takes long: refuses what surely does not fit, and nothing that may.
/// @param folder  that is there, on the disk in question
/// @param least   bytes that will be written for certain
/// @throws std::runtime_error naming the folder, what it takes and what is free; not where the disk does not
///         report what is free
void expect_room(const std::filesystem::path& folder, std::uint64_t least, Disk& disk = kernel_disk());

}  // namespace roadbalance
