#pragma once

#include <stdexcept>
#include <string>

#include "common/bus/operation.hpp"
#include "common/process/child.hpp"
#include "host/receipts/job_table.hpp"

namespace roadbalance {

/// The disk does not take the book of jobs.
struct BookRefused : std::runtime_error {
  using std::runtime_error::runtime_error;
};

Answer reply_to(const Request& request, AnswerState state, RefusalReason reason, std::string text,
                std::int64_t utc_us);

std::string in_quotes(const std::string& name);

/// In the place of results, and of what is ended nothing is left.
bool is_whole_or_nothing(JobOutcome outcome);
/// It leaves something on a disk, if only half of it.
bool stays(JobOutcome outcome);

/// What is left of a job that was ended; begins with "; ", or is empty.
std::string left_of(JobOutcome outcome);

/// Why a command of rb could not do its work, and what to do: what rb said last, or how it was ended.
std::string words_of_failure(const JobLine& line, Child& ended);

}  // namespace roadbalance
