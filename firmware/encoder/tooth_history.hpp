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

/// The latest teeth in order of time; the oldest falls out when it is full.  Allocates once.
class ToothHistory {
 public:
  explicit ToothHistory(std::size_t capacity) : teeth_(capacity) {}

  void push(NumberedTooth tooth) noexcept {
    if (size_ == teeth_.size()) drop_oldest();
    teeth_[wrapped(first_ + size_)] = tooth;
    ++size_;
  }
  /// The latest was no tooth; this one is.
  void replace_latest(NumberedTooth tooth) noexcept {
    if (empty()) return push(tooth);
    teeth_[wrapped(first_ + size_ - 1)] = tooth;
  }
  void clear() noexcept { size_ = 0; }

  bool empty() const noexcept { return size_ == 0; }
  std::size_t size() const noexcept { return size_; }
  /// 0 is the oldest.
  const NumberedTooth& operator[](std::size_t i) const noexcept { return teeth_[wrapped(first_ + i)]; }
  /// Needs at least one.
  const NumberedTooth& latest() const noexcept { return (*this)[size_ - 1]; }

  /// First tooth at or after an instant; size() if there is none.
  std::size_t first_at(std::int64_t time_ns) const noexcept {
    return first_where([&](const NumberedTooth& tooth) { return tooth.time_ns >= time_ns; });
  }
  /// First tooth with this or a higher number.
  std::size_t first_numbered(std::int64_t number) const noexcept {
    return first_where([&](const NumberedTooth& tooth) { return tooth.number >= number; });
  }

 private:
  /// A division here would be most of the encoder's work.
  std::size_t wrapped(std::size_t i) const noexcept { return i < teeth_.size() ? i : i - teeth_.size(); }

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

  std::vector<NumberedTooth> teeth_;
  std::size_t first_ = 0, size_ = 0;
};

}  // namespace roadbalance
