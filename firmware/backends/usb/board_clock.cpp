#include "firmware/backends/usb/board_clock.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace roadbalance {
namespace {

/// A packet later than this says no more than one as late as this; a second would let the line begin anew.
constexpr auto kLatest = std::chrono::milliseconds(500);
/// So long a run tells the timer's rate better than its nominal value does.
constexpr double kLongRun_s = 10.0;
constexpr double kMostWrong_s = 1.0;

}  // namespace

BoardClock::BoardClock(double tick_hz, BoardInstant begin) noexcept
    : line_(tick_hz), nominal_s_(1.0 / tick_hz), begin_(begin), to_(begin), tick_ns_(1e9 / tick_hz) {
  Scan instant;
  instant.index = static_cast<std::int64_t>(begin.ticks);
  instant.time = begin.time;
  line_.correct({&instant, 1});
}

bool BoardClock::is_possible(BoardInstant latest) const noexcept {
  // In floating point, where no stamp is too far away.
  const double behind_s = 1e-9 * ticks_behind(latest.ticks) * tick_ns_;
  return behind_s > -kMostWrong_s && behind_s - to_seconds(latest.time - to_.time) < kMostWrong_s;
}

void BoardClock::hear(BoardInstant latest) noexcept {
  const auto passed = static_cast<std::int64_t>(latest.ticks - to_.ticks);
  if (passed <= 0) return;
  Scan instant;
  instant.index = static_cast<std::int64_t>(latest.ticks);
  instant.time = std::min(latest.time, time(latest.ticks) + kLatest);
  line_.correct({&instant, 1});
  tick_ns_ = static_cast<double>((instant.time - to_.time).count()) / static_cast<double>(passed);
  to_ = {latest.ticks, instant.time};
}

NodeTime BoardClock::time(std::uint64_t ticks) const noexcept {
  return to_.time + NodeClock::duration(std::llround(ticks_behind(ticks) * tick_ns_));
}

double BoardClock::tick_s() const noexcept {
  const double run_s = to_seconds(to_.time - begin_.time);
  return run_s < kLongRun_s ? nominal_s_ : run_s / static_cast<double>(to_.ticks - begin_.ticks);
}

}  // namespace roadbalance
