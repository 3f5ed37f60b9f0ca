#pragma once

#include <filesystem>
#include <string>

#include "common/record/disk.hpp"

namespace roadbalance {

/// What a folder's segments are if they hold no event of ours: "seg-000001.lcm: no event of an LCM log from
/// byte 0 on; ...", or a log of another program and which of its channels it begins with.  Empty if one is
/// ours.
/// @throws std::system_error if they cannot be read
std::string foreign_words(const std::filesystem::path& folder, Disk& disk = kernel_disk());

}  // namespace roadbalance
