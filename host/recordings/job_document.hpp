#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "common/bus/job.hpp"

namespace roadbalance {

inline constexpr std::size_t kMostDocument = static_cast<std::size_t>(kMostParts) * kPartBytes;
/// One byte more of a job's output is read, which shows that it is too long.
inline constexpr std::size_t kMostRead = kMostDocument + 1;

/// The first kMostRead bytes of a file; empty if it cannot be read.
std::string begin_of(const std::filesystem::path& path);

std::string first_line(const std::string& text);

/// A text short enough for a page; ends with a remark if it was cut.
std::string shortened(std::string text);

}  // namespace roadbalance
