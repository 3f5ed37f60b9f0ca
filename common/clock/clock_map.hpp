#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/types/exchange.hpp"

namespace roadbalance {

/// Brings instants of one node epoch to the host's time, by the fit that came last and one before it.
///
/// Behind the last fit only its own drift is known.  Blocks that come late - those that a node kept during a
/// cable pull, or a repair - lie on the line through both fits: each is right at its instant, while the drift
/// of one that has just locked may be 200 ppm wrong.  Before it is the one before, but for a minute behind a
/// hole in the fits that which the hole began with: so long kept blocks may come (the beginning of another
/// hole within that minute is not kept).  Fits that no crystal joins (another time base, a host booted anew)
/// are not joined: then the last one's line goes back as far as it is asked.
class ClockMap {
 public:
  /// The next fit; known.
  void take(const ClockFit& fit);
  void reset() { *this = {}; }

  bool is_known() const { return last_.has_value(); }
  /// Nothing while it is not known.
  const std::optional<ClockFit>& last() const { return last_; }
  /// Those that make an empty map the same as this one, taken in this order: three at most.  Before the last
  /// one comes, if there is one, that which it is joined to, and what ended a hole between them.
  std::vector<ClockFit> fits() const;

  /// The line that holds at a node's instant, as a fit; while it is known.
  ClockFit line_at(std::int64_t node_time_ns) const;
  /// The host's instant of a node's instant, both within kClockLimit_ns; while it is known.
  std::int64_t host_time_ns(std::int64_t node_time_ns) const;

 private:
  std::optional<ClockFit> last_, before_;
  std::optional<ClockFit> hole_end_;  ///< before_ is the one that the hole began with
};

}  // namespace roadbalance
