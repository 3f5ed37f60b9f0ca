#pragma once

#include <cstdint>

#include "common/types/block.hpp"
#include "common/types/exchange.hpp"

namespace roadbalance {

// Instants that are worked out from a record.  Good messages may carry anything within their bounds, a gap of
// 2^48 scans too: an instant beyond kClockLimit_ns is as good as that limit, and differences of two do not
// overflow.

/// UTC is given up to here, in microseconds either way from 1970: to 2099.  Nanoseconds of it can be counted.
inline constexpr std::int64_t kUtcLimit_us = 4'100'000'000'000'000;

/// The instant so many scans, 0 to kIndexLimit, behind `begin_ns`, which is bounded.
inline std::int64_t time_after_ns(std::int64_t begin_ns, std::int64_t scans, std::int64_t period_ps) {
  constexpr std::int64_t kMost_ns = 2 * kClockLimit_ns;
  const double about_ns = static_cast<double>(scans) * static_cast<double>(period_ps) * 1e-3;
  const bool is_countable = about_ns < static_cast<double>(kMost_ns);
  return bounded_ns(begin_ns +
                    (is_countable ? scans / 1000 * period_ps + scans % 1000 * period_ps / 1000 : kMost_ns));
}

/// The host's instant of a node's bounded one.
inline std::int64_t host_instant_ns(const ClockFit& fit, std::int64_t node_ns) {
  return bounded_ns(fit.host_time_ns(node_ns));
}

}  // namespace roadbalance
