#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/job.hpp"

namespace roadbalance {

/// A kind of job: the command of rb that does it.  A line in job_table.cpp makes one more.
struct JobLine {
  JobKind kind;
  const char* command;
  double readings;        ///< how often it reads the recording, for its progress
  bool takes_before;      ///< it may compare with a recording, which it reads once (--before)
  DocumentKind document;  ///< kText: what it says; kPage: the file that it writes (--output)
};

/// Nothing: there is no such job.
std::optional<JobLine> job_line(JobKind kind);

/// Of rb.  @param before  empty: none
std::vector<std::string> job_arguments(const JobLine& line, const std::filesystem::path& recording,
                                       const std::filesystem::path& before,
                                       const std::filesystem::path& page);

}  // namespace roadbalance
