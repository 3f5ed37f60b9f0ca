#pragma once

#include <cstdint>
#include <filesystem>
#include <map>

namespace roadbalance {

/// Of a recording that is made of another one (`rb select`, `rb reduce`): which of its epochs is which epoch
/// of the recording that was measured, also if that was an excerpt of it in turn.  Empty: it was measured
/// itself, or made before excerpts told.  An epoch's clock is that of its origin.
/// @throws std::system_error naming the folder if it cannot be read
std::map<std::int64_t, std::int64_t> excerpt_origins(const std::filesystem::path& folder);

}  // namespace roadbalance
