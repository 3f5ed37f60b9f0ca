#include "common/clock/clock_map.hpp"

#include <cmath>

#include "common/clock/offset_line.hpp"
#include "common/types/bounded_time.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kHole_ns = 2'000'000'000;      // fits come once a second
constexpr std::int64_t kBacklog_ns = 60'000'000'000;  // the ring's and the spool's is gone by then

/// The line through two fits, as a fit at the first one's instant; nothing if no crystal has such a drift.
std::optional<ClockFit> joined(const ClockFit& before, const ClockFit& last) {
  const std::int64_t host_ns = last.host_ns - before.host_ns;
  const std::int64_t node_ns = last.node_ns - before.node_ns;
  // Uncertain ones a moment apart may show any drift.
  const bool is_slope = host_ns > 0 && node_ns > host_ns / 2 && node_ns / 2 < host_ns;
  if (last.breaks > before.breaks || !is_slope) return std::nullopt;
  const double off_s = 1e-9 * std::abs(static_cast<double>(node_ns) - static_cast<double>(host_ns));
  const double possible_s =
      DriftPrior{}.sigma * 1e-9 * static_cast<double>(host_ns) + before.uncertainty_s + last.uncertainty_s;
  if (!(off_s <= possible_s)) return std::nullopt;
  ClockFit line = before;
  line.drift = static_cast<double>(node_ns - host_ns) / static_cast<double>(host_ns);
  return line;
}

}  // namespace

void ClockMap::take(const ClockFit& fit) {
  const bool may_be_late = hole_end_ && fit.host_ns - hole_end_->host_ns < kBacklog_ns;
  if (!may_be_late || !joined(*before_, fit)) {
    before_.reset();
    hole_end_.reset();
    if (last_ && joined(*last_, fit)) before_ = last_;
    if (before_ && fit.host_ns - before_->host_ns > kHole_ns) hole_end_ = fit;
  }
  last_ = fit;
}

std::vector<ClockFit> ClockMap::fits() const {
  std::vector<ClockFit> fits;
  if (before_) fits.push_back(*before_);
  if (hole_end_ && hole_end_ != last_) fits.push_back(*hole_end_);
  if (last_) fits.push_back(*last_);
  return fits;
}

ClockFit ClockMap::line_at(std::int64_t node_time_ns) const {
  if (!before_ || node_time_ns >= last_->node_ns) return *last_;
  return node_time_ns >= before_->node_ns ? *joined(*before_, *last_) : *before_;
}

std::int64_t ClockMap::host_time_ns(std::int64_t node_time_ns) const {
  return host_instant_ns(line_at(node_time_ns), node_time_ns);
}

}  // namespace roadbalance
