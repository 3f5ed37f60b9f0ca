#pragma once

#include <cstdint>
#include <deque>

#include "common/types/clocks.hpp"

namespace roadbalance {

/// The present speed of long work, from the bytes of the last seconds.
class ByteRate {
 public:
  static constexpr std::chrono::seconds kSpan{5};

  /// @param bytes  done since the work began
  void take(std::int64_t bytes, WallTime now);
  /// Forgets the past: the work pauses, and the pause does not count.
  void forget() { taken_.clear(); }
  /// 0 while it is unknown.
  double bytes_per_s() const;

 private:
  struct Taken {
    std::int64_t bytes;
    WallTime time;
  };
  std::deque<Taken> taken_;
};

}  // namespace roadbalance
