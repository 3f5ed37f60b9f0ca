#pragma once

#include <map>
#include <string>
#include <string_view>
#include <variant>

namespace roadbalance {

/// The order for a job: the text of a request Operation::kJob, "RECORDING" or
/// "RECORDING/KEY=VALUE/KEY=VALUE".  Names of recordings have no slash.
struct JobOrder {
  std::string recording{};
  std::string options{};                           ///< the text behind the name, as it came
  std::map<std::string, std::string> option = {};  ///< by key; no value is empty
};

/// Keys: before (a recording), format, channels (names, with commas between), from and to (seconds),
/// from-mark and to-mark (numbers of marks), rate (Hz), complete (yes).
/// @return the order, or the fault of the text, for people
std::variant<JobOrder, std::string> parse_job_order(std::string_view text);

/// The value of an option that is a number.
double number_in(const JobOrder& order, const std::string& key, double otherwise);

}  // namespace roadbalance
