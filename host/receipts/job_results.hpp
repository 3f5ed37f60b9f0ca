#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "host/receipts/job_table.hpp"

namespace roadbalance {

/// Where a result is to be made: a name that nothing in the folder has, half made things included, and that
/// is not taken otherwise; else with a number behind: "monday-selected-2".
/// @throws std::runtime_error if it would be too long to be told, or all numbers are taken
/// @throws std::filesystem::filesystem_error if the folder cannot be looked into
std::filesystem::path free_place(const std::filesystem::path& folder, const ResultName& name,
                                 const std::function<bool(const std::string&)>& is_taken);

/// What a command that was ended has left of its result, if anything.  Never throws.
void discard_half(const std::filesystem::path& result);

/// Where it is and how large: "/var/lib/results/monday.h5, 12.3 MB".
std::string words_of(const std::filesystem::path& result);

}  // namespace roadbalance
