#pragma once

#include <semaphore.h>

#include <chrono>
#include <cstddef>
#include <ctime>

#include "common/process/spsc_queue.hpp"

namespace roadbalance {

/// A SpscQueue whose reader can wait for the next item.  Its writer never waits.
template <typename T>
class WakingQueue {
 public:
  /// @param capacity  items that fit
  explicit WakingQueue(std::size_t capacity) : queue_(capacity) { ::sem_init(&filled_, 0, 0); }
  WakingQueue(const WakingQueue&) = delete;
  WakingQueue& operator=(const WakingQueue&) = delete;
  ~WakingQueue() { ::sem_destroy(&filled_); }

  /// Writer: room for the next item; nullptr: none.  It is handed over by post().
  T* room() noexcept { return queue_.room(); }
  void post() noexcept {
    queue_.publish();
    ::sem_post(&filled_);
  }

  /// Reader: the oldest item, or nullptr; it stays until pop().
  const T* front() const noexcept { return queue_.front(); }
  /// Reader: after front() gave one.
  void pop() noexcept {
    queue_.pop();
    ::sem_trywait(&filled_);  // its call, unless post() has not come to that yet
  }
  /// Reader: waits until something is there, at most until then.  False: nothing came.
  bool wait_until(std::chrono::steady_clock::time_point at_most) noexcept {
    const auto ns = std::chrono::nanoseconds(at_most.time_since_epoch()).count();
    const timespec until{.tv_sec = ns / 1'000'000'000, .tv_nsec = ns % 1'000'000'000};
    // A call can be one for something that was taken before it came: the queue alone shows what there is.
    while (!front())
      if (::sem_clockwait(&filled_, CLOCK_MONOTONIC, &until) != 0) return front() != nullptr;
    return true;
  }

 private:
  SpscQueue<T> queue_;
  sem_t filled_;
};

}  // namespace roadbalance
