#include "firmware/waiting_scans.hpp"

#include <algorithm>
#include <cmath>

#include "common/types/blocks.hpp"

namespace roadbalance {
namespace {

std::size_t waiting_capacity(double rate_hz) {
  // The longest wait, a block beside it and the lag of edges behind scans.
  return static_cast<std::size_t>(std::ceil(0.25 * rate_hz)) + 4 * kScansPerBlock;
}

}  // namespace

WaitingScans::WaitingScans(double rate_hz) : scan_(waiting_capacity(rate_hz)) {}

bool WaitingScans::push(const Scan& scan) noexcept {
  if (scan.index < next_index_ || scan.index >= kIndexLimit) return false;
  if (next_index_ >= 0 && scan.index != next_index_) ++jumps_;
  next_index_ = scan.index + 1;
  scan_[static_cast<std::size_t>(tail_) % scan_.size()] = scan;
  ++tail_;
  latest_ = scan.time;
  return true;
}

WaitingScans::Run WaitingScans::next_run(const std::array<std::int64_t, 2>& borders) const noexcept {
  Run run{static_cast<int>(std::min<std::int64_t>(kScansPerBlock, tail_ - head_)), false};
  for (const std::int64_t border : borders)
    if (head_ < border && border <= head_ + run.scans) run = {static_cast<int>(border - head_), true};
  if (jumps_ > 0)
    for (int i = 1; i < run.scans; ++i)
      if (at(head_ + i).index != at(head_ + i - 1).index + 1) run = {i, true};
  run.whole = run.whole || run.scans == kScansPerBlock;
  return run;
}

void WaitingScans::take(int scans) noexcept {
  if (any_taken() && after_jump()) --jumps_;
  taken_index_ = at(head_ + scans - 1).index + 1;
  head_ += scans;
}

}  // namespace roadbalance
