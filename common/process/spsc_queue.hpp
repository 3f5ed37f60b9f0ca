#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace roadbalance {

/// A bounded queue from one thread to one other that never waits, for a reader with a deadline; see
/// channel.hpp for processes that may wait.  All memory is taken at construction.
template <typename T>
class SpscQueue {
 public:
  /// @param capacity  items that fit
  explicit SpscQueue(std::size_t capacity) : items_(capacity + 1) {}

  /// Writer: where the next item is written before publish(); nullptr: it is full.
  T* room() noexcept {
    const std::size_t at = end_.load(std::memory_order_relaxed);
    return after(at) == begin_.load(std::memory_order_acquire) ? nullptr : &items_[at];
  }
  void publish() noexcept {
    end_.store(after(end_.load(std::memory_order_relaxed)), std::memory_order_release);
  }
  /// Writer: false if it is full.
  [[nodiscard]] bool push(const T& item) noexcept {
    T* const place = room();
    if (!place) return false;
    *place = item;
    publish();
    return true;
  }

  /// Reader: the oldest item, or nullptr; it stays until pop().
  const T* front() const noexcept {
    const std::size_t at = begin_.load(std::memory_order_relaxed);
    return at == end_.load(std::memory_order_acquire) ? nullptr : &items_[at];
  }
  /// Reader: after front() gave one.
  void pop() noexcept {
    begin_.store(after(begin_.load(std::memory_order_relaxed)), std::memory_order_release);
  }

 private:
  std::size_t after(std::size_t at) const noexcept { return at + 1 == items_.size() ? 0 : at + 1; }

  std::vector<T> items_;
  // On cache lines of their own: each is written by one thread and read by the other all the time.
  alignas(64) std::atomic<std::size_t> begin_{0};
  alignas(64) std::atomic<std::size_t> end_{0};
};

}  // namespace roadbalance
