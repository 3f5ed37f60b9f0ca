#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace roadbalance::board {

/// A queue from interrupts to the main loop, without locks: each end is written by one side only.
template <class Item, std::size_t kItems>
class InterruptRing {
  static_assert(std::has_single_bit(kItems), "the counters wrap");

 public:
  /// Interrupt: where the next item is written before publish(); null if the ring is full.
  Item* room() {
    const std::uint32_t end = end_.load(std::memory_order_relaxed);
    return end - begin_.load(std::memory_order_acquire) == kItems ? nullptr : &items_[end % kItems];
  }
  void publish() { end_.store(end_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  /// Interrupt: how many items fit.  Main loop: at least so many fit.
  std::size_t free() const { return kItems - size(); }

  /// Main loop: how many there are; more may come at any time.
  std::size_t size() const {
    return end_.load(std::memory_order_acquire) - begin_.load(std::memory_order_acquire);
  }
  /// Main loop: the k-th oldest, k < size().
  const Item& operator[](std::size_t k) const {
    return items_[(begin_.load(std::memory_order_relaxed) + k) % kItems];
  }
  /// Main loop: removes the `count` oldest, count <= size().
  void drop(std::size_t count) {
    begin_.store(begin_.load(std::memory_order_relaxed) + static_cast<std::uint32_t>(count),
                 std::memory_order_release);
  }

  /// While no interrupt comes.
  void clear() {
    begin_.store(0, std::memory_order_relaxed);
    end_.store(0, std::memory_order_release);
  }

 private:
  std::array<Item, kItems> items_{};
  std::atomic<std::uint32_t> begin_ = 0;  ///< items removed so far
  std::atomic<std::uint32_t> end_ = 0;    ///< items published so far
};

}  // namespace roadbalance::board
