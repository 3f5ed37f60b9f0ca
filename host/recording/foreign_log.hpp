#pragma once

#include <filesystem>
#include <string>

#include "common/record/disk.hpp"

namespace roadbalance {

/// Describes a folder whose segments hold no event of ours: "seg-000001.lcm: no event of an LCM log from byte
/// 0 on;
/// ...", or a log of another program and the channel that it begins with.  Empty if one event is ours.
/// @throws std::system_error if they cannot be read
std::string foreign_words(const std::filesystem::path& folder, Disk& disk = kernel_disk());

}  // namespace roadbalance
