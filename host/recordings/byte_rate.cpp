#include "host/recordings/byte_rate.hpp"

#include <chrono>

namespace roadbalance {

void ByteRate::take(std::int64_t bytes, WallTime now) {
  if (!taken_.empty() && now <= taken_.back().time) return;
  taken_.push_back({bytes, now});
  while (taken_.size() > 2 && now - taken_[1].time >= kSpan) taken_.pop_front();
}

double ByteRate::bytes_per_s() const {
  constexpr double kLeast_s = 0.5;
  if (taken_.empty()) return 0.0;
  const double time_s = std::chrono::duration<double>(taken_.back().time - taken_.front().time).count();
  if (time_s < kLeast_s) return 0.0;
  return static_cast<double>(taken_.back().bytes - taken_.front().bytes) / time_s;
}

}  // namespace roadbalance
