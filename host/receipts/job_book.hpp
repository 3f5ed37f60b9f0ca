#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/bus/job.hpp"

namespace roadbalance {

/// A job as it is remembered when rb-recordings begins again.
struct BookedJob {
  Job job;
  std::int64_t asker = 0, request = 0;  ///< of who asked for it
  std::filesystem::path result{};       ///< what it makes; empty: nothing that stays
};

/// The file of jobs in the folder of results.
inline constexpr const char* kJobBookFile = "jobs.json";

std::string encode_job_book(const std::vector<BookedJob>& jobs);
/// Nothing if it cannot be: more jobs than are told, an unknown kind or state, a result elsewhere.
/// @param results  folder that all results must lie in, directly
std::optional<std::vector<BookedJob>> decode_job_book(std::string_view text,
                                                      const std::filesystem::path& results);

}  // namespace roadbalance
