#include "firmware/backends/usb/board_clock.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace roadbalance {
namespace {

/// A packet later than this adds no more than one as late as this; a second would let the line begin anew.
constexpr auto kLatest = std::chrono::milliseconds(500);
/// A run as long as this shows the timer's rate better than its nominal value does.
constexpr double kLongRun_s = 10.0;
constexpr double kMostWrong_s = 1.0;
/// Share of the time that passes: two oscillators of 50 ppm each.
constexpr double kDrift = 100e-6;
constexpr double kTellingRun_s = 1.0;
/// Share of the time that passes, so that what is taken off does not step.
constexpr double kFollowing = 1e-3;

}  // namespace

BoardClock::BoardClock(double tick_hz, BoardInstant begin) noexcept
    : line_(tick_hz),
      nominal_s_(1.0 / tick_hz),
      begin_(begin),
      heard_(begin),
      to_(begin),
      tick_ns_(1e9 / tick_hz) {
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
  const auto ticks = static_cast<double>(passed);
  heard_ = {latest.ticks, instant.time};

  const double most = kFollowing * 1e9 * ticks * nominal_s_;
  taken_off_ns_ += std::clamp(lateness_ns() - taken_off_ns_, -most, most);
  const NodeTime end = instant.time - NodeClock::duration(std::llround(taken_off_ns_));
  tick_ns_ = static_cast<double>((end - to_.time).count()) / ticks;
  to_ = {latest.ticks, end};
}

void BoardClock::compare(const BoardExchange& exchange) noexcept {
  if (is_possible(exchange.instant())) exchange_[exchanges_++ % kExchanges] = exchange;
}

std::span<const BoardExchange> BoardClock::exchanges() const noexcept {
  return std::span(exchange_).first(std::min(exchanges_, kExchanges));
}

double BoardClock::wrong_ns(const BoardExchange& exchange, std::uint64_t ticks) const noexcept {
  constexpr double kReading_ns = 1.0;
  const double age_s = nominal_s_ * static_cast<double>(static_cast<std::int64_t>(ticks - exchange.ticks));
  return kReading_ns + static_cast<double>(exchange.half_round_trip().count()) +
         1e9 * kDrift * std::abs(age_s);
}

/// By the best exchange and the one at the beginning, once these determine more than the nominal rate does.
double BoardClock::exchanged_tick_s() const noexcept {
  const auto best = std::ranges::min_element(
      exchanges(), {}, [&](const BoardExchange& exchange) { return wrong_ns(exchange, heard_.ticks); });
  const auto ticks = static_cast<double>(static_cast<std::int64_t>(best->ticks - begin_.ticks));
  if (ticks * nominal_s_ < kTellingRun_s) return nominal_s_;
  const double measured_s = to_seconds(best->instant().time - begin_.time) / ticks;
  return std::clamp(measured_s, nominal_s_ * (1.0 - kDrift), nominal_s_ * (1.0 + kDrift));
}

/// The line of arrivals at its end.
double BoardClock::lateness_ns() const noexcept {
  if (exchanges_ == 0) return 0.0;
  const double tick_ns = 1e9 * exchanged_tick_s();
  double weights = 0.0, sum = 0.0;
  for (const BoardExchange& exchange : exchanges()) {
    const double wrong = wrong_ns(exchange, heard_.ticks), weight = 1.0 / (wrong * wrong);
    const auto passed = static_cast<double>(static_cast<std::int64_t>(heard_.ticks - exchange.ticks));
    const auto arrived_ns = static_cast<double>((heard_.time - exchange.instant().time).count());
    weights += weight;
    sum += weight * (arrived_ns - tick_ns * passed);
  }
  return sum / weights;
}

NodeTime BoardClock::time(std::uint64_t ticks) const noexcept {
  return to_.time + NodeClock::duration(std::llround(ticks_behind(ticks) * tick_ns_));
}

double BoardClock::tick_s() const noexcept {
  const double run_s = to_seconds(to_.time - begin_.time);
  return run_s < kLongRun_s ? nominal_s_ : run_s / static_cast<double>(to_.ticks - begin_.ticks);
}

}  // namespace roadbalance
