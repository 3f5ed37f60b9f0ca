#pragma once

#include <filesystem>

namespace roadbalance {

/// Writes manifest.json: the segments and their sizes, for people and for transfer.  It can be made again at
/// any time and is never trusted over the segments.  @throws std::system_error naming the file
void write_manifest(const std::filesystem::path& folder);

}  // namespace roadbalance
