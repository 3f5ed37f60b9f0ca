#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/bus/job.hpp"
#include "common/bus/recording.hpp"
#include "host/recordings/job_order.hpp"

namespace roadbalance {

/// The kind of a job's result.
enum class JobOutcome {
  kText,       ///< its output
  kPage,       ///< a page to save and print
  kFile,       ///< a file among the results
  kRecording,  ///< a recording among the results
  kCopy,       ///< a copy in the folder for transfers, where an unfinished one stays and is resumed
};

/// A kind of job: the command of rb that does it.  A line in job_table.cpp adds one.
struct JobLine {
  JobKind kind;
  const char* command;
  JobOutcome outcome;                         ///< see outcome_of()
  std::span<const std::string_view> options;  ///< allowed keys of an order
  std::string_view needed;                    ///< required key; empty: none
};

/// The line of a kind; nothing: there is no such job.
std::optional<JobLine> job_line(JobKind kind);

/// The kind of result of this order: a complete report is too long for messages and becomes a file.
JobOutcome outcome_of(const JobLine& line, const JobOrder& order);

/// The fault of the order's options for this job; empty: none.
std::string fault_of_order(const JobLine& line, const JobOrder& order);

/// Name of the result and its extension: "monday-selected", ".h5".
struct ResultName {
  std::string stem, extension{};
};
ResultName result_name(const JobLine& line, const JobOrder& order);

/// The second file of a result: the DBC file that describes the frames of a candump log; empty: none.
std::filesystem::path beside(const JobOrder& order, const std::filesystem::path& result);

/// The arguments of rb.
/// @param before  empty: none
/// @param to      file or folder that it writes, or the folder that it copies into
std::vector<std::string> job_arguments(const JobLine& line, const JobOrder& order,
                                       const std::filesystem::path& recording,
                                       const std::filesystem::path& before, const std::filesystem::path& to);

/// An estimate of the bytes that the job reads, its own output included.
/// @param before_bytes  of the recording that it compares with
std::int64_t bytes_to_read(const JobLine& line, const JobOrder& order, const RecordingSummary& recording,
                           std::int64_t before_bytes);

}  // namespace roadbalance
