#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace roadbalance {

/// Recordings, and folders of recordings, as somebody named them: the recordings by name, those of one name
/// by where they are.  The order in which they were named makes no difference.
///
/// A recording is a folder that holds a segment.  Of a folder of recordings those right in it count, but for
/// what begins with a dot and copies half made (NAME.part).
/// @throws ConfigError if one is named twice or a folder holds no recording,
/// std::filesystem::filesystem_error
///         if one is not there
std::vector<std::filesystem::path> recordings_given(std::span<const std::string> named);

/// Bytes of its segments.
std::uint64_t bytes_of_recording(const std::filesystem::path& recording);

}  // namespace roadbalance
