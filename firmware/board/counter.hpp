#pragma once

#include <atomic>
#include <cstdint>

namespace roadbalance::board {

/// Counted in interrupts, read by the main loop.  One side adds, so that no read-modify-write is needed.
class Counter {
 public:
  void add(std::uint32_t count = 1) {
    value_.store(value_.load(std::memory_order_relaxed) + count, std::memory_order_relaxed);
  }
  std::uint32_t value() const { return value_.load(std::memory_order_relaxed); }
  void clear() { value_.store(0, std::memory_order_relaxed); }

 private:
  std::atomic<std::uint32_t> value_ = 0;
};

}  // namespace roadbalance::board
