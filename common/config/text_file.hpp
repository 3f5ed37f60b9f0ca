#pragma once

#include <cstddef>
#include <string>

namespace roadbalance {

/// A whole file, or of one that is longer than `most` bytes that much and a little more.
/// @throws std::system_error naming the file and the system's reason, for a folder too
std::string read_text_file(const std::string& path, std::size_t most = static_cast<std::size_t>(-1));

}  // namespace roadbalance
