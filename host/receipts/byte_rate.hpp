#pragma once

#include <cstdint>
#include <deque>

namespace roadbalance {

/// How fast long work goes now: the bytes of the last seconds.
class ByteRate {
 public:
  static constexpr std::int64_t kSpan_us = 5'000'000;

  /// @param bytes  gone through since the work began
  void take(std::int64_t bytes, std::int64_t utc_us);
  /// The work stands still for a while that does not count.
  void forget() { taken_.clear(); }
  /// 0 while it is not known.
  double bytes_per_s() const;

 private:
  struct Taken {
    std::int64_t bytes, utc_us;
  };
  std::deque<Taken> taken_;
};

}  // namespace roadbalance
