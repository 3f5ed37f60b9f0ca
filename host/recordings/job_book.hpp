#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/bus/job.hpp"

namespace roadbalance {

/// A job as it is stored for the next run of rb-recordings.
struct BookedJob {
  Job job;
  std::int64_t asker = 0, request = 0;  ///< of the page that asked for it
  std::filesystem::path result{};       ///< file or folder that it makes; empty: nothing that stays
};

/// The file of jobs in the folder of results.
inline constexpr const char* kJobBookFile = "jobs.json";

std::string encode_job_book(const std::vector<BookedJob>& jobs);
/// Nothing if the text is invalid: more than kMostJobs, an unknown kind or state, a result elsewhere.
/// @param results  folder that all results must lie in, directly
std::optional<std::vector<BookedJob>> decode_job_book(std::string_view text,
                                                      const std::filesystem::path& results);

/// The book of jobs on its disk, in the folder of results.
class JobBookFile {
 public:
  explicit JobBookFile(std::filesystem::path results) : results_(std::move(results)) {}

  /// None if there is no book, or if it cannot be read, which is reported on standard error.
  std::vector<BookedJob> read() const;

  /// Writes the jobs by number; durable on return.  Makes the folder.
  /// @throws std::filesystem::filesystem_error, std::system_error naming the folder or file
  void write(std::vector<BookedJob> jobs) const;

 private:
  std::filesystem::path results_;
};

}  // namespace roadbalance
