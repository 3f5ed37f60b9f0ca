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
#include "host/receipts/job_order.hpp"

namespace roadbalance {

/// What comes of a job.
enum class JobOutcome {
  kText,       ///< what it says
  kPage,       ///< a page to save and print
  kFile,       ///< a file among the results
  kRecording,  ///< a recording among the results
  kCopy,       ///< a copy in the folder for transfers, where what is half done stays and goes on
};

/// A kind of job: the command of rb that does it.  A line in job_table.cpp makes one more.
struct JobLine {
  JobKind kind;
  const char* command;
  JobOutcome outcome;                         ///< unless the order says otherwise
  std::span<const std::string_view> options;  ///< keys that an order may have
  std::string_view needed;                    ///< the one that it must have; empty: none
};

/// Nothing: there is no such job.
std::optional<JobLine> job_line(JobKind kind);

/// The account of the whole drive is too long to be told part by part: of that order a file is made.
JobOutcome outcome_of(const JobLine& line, const JobOrder& order);

/// Why these options are none of this job's; empty: they are.
std::string fault_of_order(const JobLine& line, const JobOrder& order);

/// Name of what it makes, and its ending: "monday-selected", ".h5".
struct ResultName {
  std::string stem, extension{};
};
ResultName result_name(const JobLine& line, const JobOrder& order);

/// The other file that is made with a result: the DBC file that tells what the frames of a candump log mean;
/// empty: none.
std::filesystem::path beside(const JobOrder& order, const std::filesystem::path& result);

/// Of rb.
/// @param before  empty: none
/// @param to      what it writes, or the folder it is to be taken to
std::vector<std::string> job_arguments(const JobLine& line, const JobOrder& order,
                                       const std::filesystem::path& recording,
                                       const std::filesystem::path& before, const std::filesystem::path& to);

/// About how much it reads, what it has written included.
/// @param before_bytes  of the recording it compares with
std::int64_t bytes_to_read(const JobLine& line, const JobOrder& order, const RecordingReceipt& recording,
                           std::int64_t before_bytes);

}  // namespace roadbalance
