#include "host/receipts/byte_rate.hpp"

namespace roadbalance {

void ByteRate::take(std::int64_t bytes, std::int64_t utc_us) {
  if (!taken_.empty() && utc_us <= taken_.back().utc_us) {
    if (utc_us == taken_.back().utc_us) return;
    forget();  // the clock was set back
  }
  taken_.push_back({bytes, utc_us});
  while (taken_.size() > 2 && utc_us - taken_[1].utc_us >= kSpan_us) taken_.pop_front();
}

double ByteRate::bytes_per_s() const {
  constexpr std::int64_t kLeast_us = 500'000;
  if (taken_.empty()) return 0.0;
  const std::int64_t us = taken_.back().utc_us - taken_.front().utc_us;
  if (us < kLeast_us) return 0.0;
  return 1e6 * static_cast<double>(taken_.back().bytes - taken_.front().bytes) / static_cast<double>(us);
}

}  // namespace roadbalance
