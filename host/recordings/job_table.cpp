#include "host/recordings/job_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace roadbalance {
namespace {

constexpr std::string_view kComplete = "complete";

using Keys = std::span<const std::string_view>;
constexpr std::array<std::string_view, 2> kOfReport{"before", kComplete};
constexpr std::array<std::string_view, 4> kOfExport{"format", "from", "to", "channels"};
constexpr std::array<std::string_view, 5> kOfSelect{"from", "to", "from-mark", "to-mark", "channels"};
constexpr std::array<std::string_view, 1> kOfReduce{"rate"};

constexpr std::array kLines{
    JobLine{JobKind::kVerify, "verify", JobOutcome::kText, Keys{}, ""},
    JobLine{JobKind::kIdentify, "identify", JobOutcome::kText, Keys{}, ""},
    JobLine{JobKind::kReport, "report", JobOutcome::kPage, kOfReport, ""},
    JobLine{JobKind::kExport, "export", JobOutcome::kFile, kOfExport, "format"},
    JobLine{JobKind::kSelect, "select", JobOutcome::kRecording, kOfSelect, ""},
    JobLine{JobKind::kReduce, "reduce", JobOutcome::kRecording, kOfReduce, "rate"},
    JobLine{JobKind::kTransfer, "transfer", JobOutcome::kCopy, Keys{}, ""},
};

constexpr std::string_view kCandump = "candump";

/// File name extensions as other programs expect them.
constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kExtensions{{{"mdf4", ".mf4"},
                                                                                    {"hdf5", ".h5"},
                                                                                    {"mat", ".mat"},
                                                                                    {"uff58", ".uff"},
                                                                                    {"wav", ".wav"},
                                                                                    {"csv", ".csv"},
                                                                                    {"mcap", ".mcap"},
                                                                                    {kCandump, ".log"}}};

std::string_view extension_of(std::string_view format) {
  const auto* found = std::ranges::find(kExtensions, format, &decltype(kExtensions)::value_type::first);
  return found == kExtensions.end() ? std::string_view{} : found->second;
}

std::string formats() {
  std::string all;
  for (const auto& [format, extension] : kExtensions) (all += all.empty() ? "" : ", ") += format;
  return all;
}

/// The share of a recording between the order's times; 1 if it names marks, whose times are unknown here.
double share_of_time(const JobOrder& order, const RecordingSummary& recording) {
  const double seconds = recording.node.empty() ? 0.0 : recording.node.front().seconds;
  if (seconds <= 0.0 || order.option.contains("from-mark") || order.option.contains("to-mark")) return 1.0;
  const double from_s = std::max(0.0, number_in(order, "from", 0.0));
  const double to_s = std::min(seconds, number_in(order, "to", seconds));
  return std::clamp((to_s - from_s) / seconds, 0.0, 1.0);
}

double share_of_rate(const JobOrder& order, const RecordingSummary& recording) {
  if (recording.node.empty() || recording.node.front().seconds <= 0.0) return 1.0;
  const auto& node = recording.node.front();
  const double rate_hz = static_cast<double>(node.samples) / node.seconds;
  return rate_hz > 0.0 ? std::clamp(number_in(order, "rate", rate_hz) / rate_hz, 0.0, 1.0) : 1.0;
}

bool is_complete(const JobOrder& order) {
  return order.option.contains(std::string(kComplete));
}

/// How often the recording is read; parts count by their share.
double readings(const JobLine& line, const JobOrder& order, const RecordingSummary& recording) {
  switch (line.kind) {
    case JobKind::kVerify:
    case JobKind::kIdentify:
      return 1.0;
    case JobKind::kReport:
      return is_complete(order) ? 5.0 : 3.0;
    case JobKind::kExport:  // the survey, then once for each node
      return 1.0 + static_cast<double>(std::max<std::size_t>(1, recording.node.size()));
    case JobKind::kSelect:  // the survey, the copying, and the new recording to prove it
      return 2.0 + share_of_time(order, recording);
    case JobKind::kReduce:
      return 2.0 + share_of_rate(order, recording);
    case JobKind::kTransfer:
      return 2.0;
  }
  return 1.0;
}

}  // namespace

std::optional<JobLine> job_line(JobKind kind) {
  const auto* line = std::ranges::find(kLines, kind, &JobLine::kind);
  if (line == kLines.end()) return std::nullopt;
  return *line;
}

JobOutcome outcome_of(const JobLine& line, const JobOrder& order) {
  return is_complete(order) ? JobOutcome::kFile : line.outcome;
}

std::string fault_of_order(const JobLine& line, const JobOrder& order) {
  for (const auto& [key, value] : order.option)
    if (std::ranges::find(line.options, key) == line.options.end())
      return key + " \"" + value + "\" has no meaning for rb " + line.command;
  if (!line.needed.empty() && !order.option.contains(std::string(line.needed)))
    return "rb " + std::string(line.command) + " needs a " + std::string(line.needed);
  if (const auto format = order.option.find("format");
      format != order.option.end() && extension_of(format->second).empty())
    return "format \"" + format->second + "\": allowed: " + formats();
  return "";
}

ResultName result_name(const JobLine& line, const JobOrder& order) {
  if (line.kind == JobKind::kSelect) return {order.recording + "-selected"};
  if (line.kind == JobKind::kReduce) return {order.recording + "-reduced-" + order.option.at("rate") + "Hz"};
  if (line.kind == JobKind::kExport)
    return {order.recording, std::string(extension_of(order.option.at("format")))};
  if (line.kind == JobKind::kReport) return {order.recording + "-report", ".html"};
  return {order.recording};
}

std::filesystem::path beside(const JobOrder& order, const std::filesystem::path& result) {
  const auto format = order.option.find("format");
  if (format == order.option.end() || format->second != kCandump) return {};
  return std::filesystem::path(result).replace_extension(".dbc");
}

std::vector<std::string> job_arguments(const JobLine& line, const JobOrder& order,
                                       const std::filesystem::path& recording,
                                       const std::filesystem::path& before, const std::filesystem::path& to) {
  std::vector<std::string> arguments{line.command, recording.string()};
  if (!before.empty()) arguments.insert(arguments.end(), {"--before", before.string()});
  // Key and value in one argument: no value can be taken for an option.
  for (const auto& [key, value] : order.option)
    if (key == kComplete)
      arguments.push_back("--" + key);
    else if (key != "before")
      arguments.push_back("--" + key + "=" + value);
  if (line.outcome == JobOutcome::kCopy)
    arguments.insert(arguments.end(), {"--to", to.string()});
  else if (line.outcome != JobOutcome::kText)
    arguments.insert(arguments.end(), {"--output", to.string()});
  if (const auto dbc = beside(order, to); !dbc.empty())
    arguments.insert(arguments.end(), {"--dbc", dbc.string()});
  return arguments;
}

std::int64_t bytes_to_read(const JobLine& line, const JobOrder& order, const RecordingSummary& recording,
                           std::int64_t before_bytes) {
  const double bytes = readings(line, order, recording) * static_cast<double>(recording.bytes);
  return std::max<std::int64_t>(1, std::llround(bytes) + before_bytes);
}

}  // namespace roadbalance
