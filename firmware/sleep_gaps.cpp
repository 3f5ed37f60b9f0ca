#include "firmware/sleep_gaps.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace roadbalance {
namespace {

// A device may take so long to be there again; stamps that show no jump by then are of a clock that slept,
// too.
constexpr std::chrono::seconds kPatience{10};

}  // namespace

SleepGaps::SleepGaps(FrontEnd& inside, double rate_hz, std::function<MachineClock::duration()> slept)
    : inside_(inside), rate_hz_(rate_hz), slept_so_far_(std::move(slept)), slept_(slept_so_far_()) {}

Read SleepGaps::read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample> signals) noexcept {
  const Read read = inside_.read(scans, edges, signals);
  if (inside_.waits()) return read;
  const MachineClock::duration slept = slept_so_far_();
  if (slept > slept_ && has_last_) {
    pending_ += slept - slept_;
    give_up_at_ = last_time_ + kPatience;
  }
  slept_ = slept;
  for (Scan& scan : scans.first(read.scans)) correct(scan);
  return read;
}

void SleepGaps::correct(Scan& scan) noexcept {
  const NodeClock::duration since = scan.time - last_time_;
  if (pending_.count() > 0 && since > pending_ / 2) {
    const std::int64_t by_time = std::llround(to_seconds(since) * rate_hz_);
    behind_ += std::max<std::int64_t>(0, by_time - (scan.index - last_index_));
    scan.after_sleep = true;
    pending_ = {};
  } else if (scan.time > give_up_at_) {
    pending_ = {};
  }
  has_last_ = true;
  last_index_ = scan.index;
  last_time_ = scan.time;
  scan.index += behind_;
}

}  // namespace roadbalance
