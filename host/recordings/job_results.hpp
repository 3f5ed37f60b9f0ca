#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "host/recordings/job_table.hpp"

namespace roadbalance {

/// The path for a result: a name that nothing in the folder has, unfinished results included, and that is not
/// taken otherwise; if need be with a number: "monday-selected-2".
/// @throws std::runtime_error if it would be too long for a message, or all numbers are taken
/// @throws std::filesystem::filesystem_error if the folder cannot be read
std::filesystem::path free_place(const std::filesystem::path& folder, const ResultName& name,
                                 const std::function<bool(const std::string&)>& is_taken);

/// Removes the unfinished result of a command that was ended, if there is one.  Never throws.
void discard_half(const std::filesystem::path& result);

/// Path and size of a result: "/var/lib/results/monday.h5, 12.3 MB".
std::string words_of(const std::filesystem::path& result);

}  // namespace roadbalance
