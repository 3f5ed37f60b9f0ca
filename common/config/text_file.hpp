#pragma once

#include <string>

namespace roadbalance {

/// A whole file.
/// @throws std::system_error naming the file and the system's reason, for a folder too
std::string read_text_file(const std::string& path);

}  // namespace roadbalance
