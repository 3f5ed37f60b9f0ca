#include "common/link/scan_line.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {
namespace {

/// Nothing if `to` does not lie behind.
std::optional<double> ns_per_scan(const BlockHeader& from, const BlockHeader& to) {
  const std::int64_t scans = to.first_scan - from.first_scan;
  if (scans <= 0) return std::nullopt;
  return static_cast<double>(to.time_ns - from.time_ns) / static_cast<double>(scans);
}

}  // namespace

bool ScanLine::carries_scan(BlockKind kind) {
  return kind == BlockKind::kScan || kind == BlockKind::kGap || kind == BlockKind::kEnd;
}

void ScanLine::take(BlockKind kind, const BlockHeader& header) {
  if (!carries_scan(kind)) return;
  if (last_) ns_per_scan_ = ns_per_scan(*last_, header).value_or(ns_per_scan_);
  last_ = header;
}

std::optional<std::int64_t> ScanLine::time_ns(std::int64_t scan, const BlockHeader* behind) const {
  if (!last_) return behind ? std::optional(behind->time_ns) : std::nullopt;
  const double slope = (behind ? ns_per_scan(*last_, *behind) : std::nullopt).value_or(ns_per_scan_);
  constexpr auto kMost_ns = 2.0 * static_cast<double>(kClockLimit_ns);
  const double since_ns = static_cast<double>(scan - last_->first_scan) * slope;
  return bounded_ns(last_->time_ns + std::llround(std::clamp(since_ns, -kMost_ns, kMost_ns)));
}

}  // namespace roadbalance
