#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace roadbalance {

/// A pulse and the tooth that made it; numbers grow over all turns.
struct NumberedTooth {
  std::int64_t time_ns = 0;
  std::int64_t number = 0;
};

/// The latest items in order of `time_ns`; the oldest falls out when it is full.  Allocates once.
template <typename Item>
class History {
 public:
  explicit History(std::size_t capacity) : item_(capacity) {}

  void push(const Item& item) noexcept {
    if (size_ == item_.size()) drop_oldest();
    item_[wrapped(first_ + size_)] = item;
    ++size_;
  }
  /// The latest was none; this one is.
  void replace_latest(const Item& item) noexcept {
    if (empty()) return push(item);
    item_[wrapped(first_ + size_ - 1)] = item;
  }
  void clear() noexcept { size_ = 0; }

  bool empty() const noexcept { return size_ == 0; }
  std::size_t size() const noexcept { return size_; }
  /// 0 is the oldest.
  const Item& operator[](std::size_t i) const noexcept { return item_[wrapped(first_ + i)]; }
  /// Needs at least one.
  const Item& latest() const noexcept { return (*this)[size_ - 1]; }

  /// First item at or after an instant; size() if there is none.
  std::size_t first_at(std::int64_t time_ns) const noexcept {
    return first_where([&](const Item& item) { return item.time_ns >= time_ns; });
  }
  /// First item with this or a higher number.
  std::size_t first_numbered(std::int64_t number) const noexcept {
    return first_where([&](const Item& item) { return item.number >= number; });
  }

 private:
  /// A division here would be most of the encoder's work.
  std::size_t wrapped(std::size_t i) const noexcept { return i < item_.size() ? i : i - item_.size(); }

  void drop_oldest() noexcept {
    first_ = wrapped(first_ + 1);
    --size_;
  }

  template <typename Reached>
  std::size_t first_where(Reached reached) const noexcept {
    std::size_t low = 0, high = size_;
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      if (reached((*this)[middle]))
        high = middle;
      else
        low = middle + 1;
    }
    return low;
  }

  std::vector<Item> item_;
  std::size_t first_ = 0, size_ = 0;
};

using ToothHistory = History<NumberedTooth>;

}  // namespace roadbalance
