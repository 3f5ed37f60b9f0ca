#pragma once

#include <cstdint>
#include <deque>

#include "common/clock/clocks.hpp"

namespace roadbalance {

/// How fast long work goes now: the bytes of the last seconds.
class ByteRate {
 public:
  static constexpr std::chrono::seconds kSpan{5};

  /// @param bytes  gone through since the work began
  void take(std::int64_t bytes, WallTime now);
  /// The work stands still for a while that does not count.
  void forget() { taken_.clear(); }
  /// 0 while it is not known.
  double bytes_per_s() const;

 private:
  struct Taken {
    std::int64_t bytes;
    WallTime time;
  };
  std::deque<Taken> taken_;
};

}  // namespace roadbalance
