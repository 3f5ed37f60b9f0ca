#include "host/receipts/job_table.hpp"

#include <algorithm>
#include <array>

namespace roadbalance {
namespace {

constexpr std::array kLines{
    JobLine{JobKind::kVerify, "verify", 1, false, DocumentKind::kText},
    JobLine{JobKind::kIdentify, "identify", 1, false, DocumentKind::kText},
    JobLine{JobKind::kReport, "report", 3, true, DocumentKind::kPage},
};

}  // namespace

std::optional<JobLine> job_line(JobKind kind) {
  const auto* line = std::ranges::find(kLines, kind, &JobLine::kind);
  if (line == kLines.end()) return std::nullopt;
  return *line;
}

std::vector<std::string> job_arguments(const JobLine& line, const std::filesystem::path& recording,
                                       const std::filesystem::path& before,
                                       const std::filesystem::path& page) {
  std::vector<std::string> arguments{line.command, recording.string()};
  if (!before.empty()) arguments.insert(arguments.end(), {"--before", before.string()});
  if (line.document == DocumentKind::kPage) arguments.insert(arguments.end(), {"--output", page.string()});
  return arguments;
}

}  // namespace roadbalance
