#include "firmware/backends/usb/board_pair.hpp"

#include <cassert>
#include <cmath>

namespace roadbalance {
namespace {

constexpr double kOscillators = 200e-6;  ///< two of 100 ppm, one fast, one slow

}  // namespace

BoardPair::BoardPair(std::size_t boards) : queue_(boards) {
  assert(boards == 1 || boards == 2);
}

void BoardPair::start(std::array<std::uint32_t, 2> tick_hz, double rate_hz) noexcept {
  for (Queue& queue : queue_) queue.begin = queue.size = 0;
  for (std::size_t k = 0; k < queue_.size(); ++k) tick_s_[k] = 1.0 / tick_hz[k];
  tolerance_s_ = 0.25 / rate_hz;
  aligned_ = true;
  proved_ = false;
}

bool BoardPair::add(std::size_t board, const BoardScan& scan) noexcept {
  Queue& queue = queue_[board];
  const bool is_full = queue.size == kScans;
  if (is_full) queue.pop();
  queue.scan[(queue.begin + queue.size++) % kScans] = scan;
  return !is_full;
}

bool BoardPair::keeps_step(const BoardScan& first, const BoardScan& second) const noexcept {
  if (!proved_) return true;
  const double first_s = static_cast<double>(first.ticks - ticks_[0]) * tick_s_[0];
  const double second_s = static_cast<double>(second.ticks - ticks_[1]) * tick_s_[1];
  return std::abs(first_s - second_s) <= tolerance_s_ + kOscillators * first_s;
}

BoardPair::Common BoardPair::front() noexcept {
  if (queue_.size() == 1) return {queue_[0].size > 0 ? &queue_[0].front() : nullptr, nullptr};
  while (aligned_ && queue_[0].size > 0 && queue_[1].size > 0) {
    const BoardScan &first = queue_[0].front(), &second = queue_[1].front();
    if (first.index < second.index) {
      queue_[0].pop();
    } else if (second.index < first.index) {
      queue_[1].pop();
    } else {
      aligned_ = keeps_step(first, second);
      if (aligned_) return {&first, &second};
    }
  }
  return {};
}

void BoardPair::drop() noexcept {
  for (std::size_t k = 0; k < queue_.size(); ++k) {
    ticks_[k] = queue_[k].front().ticks;
    queue_[k].pop();
  }
  proved_ = true;
}

}  // namespace roadbalance
