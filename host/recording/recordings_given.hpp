#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace roadbalance {

/// Resolves arguments that name recordings, or folders of recordings: returns the recordings by name, those
/// of one name by path.  The order of the arguments makes no difference.
///
/// A recording is a folder that holds a segment.  A folder of recordings stands for those directly in it,
/// except names that begin with a dot, and unfinished copies (NAME.part).
/// @throws ConfigError if one is named twice or a folder holds no recording,
/// std::filesystem::filesystem_error
///         if one is not there
std::vector<std::filesystem::path> recordings_given(std::span<const std::string> named);

/// Bytes of its segments.
std::uint64_t bytes_of_recording(const std::filesystem::path& recording);

}  // namespace roadbalance
