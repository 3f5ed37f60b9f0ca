#include "common/angle/counter_track.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "common/angle/least_squares.hpp"

namespace roadbalance {

CounterTrack::CounterTrack(const CounterLatency& latency, std::int64_t step)
    : latency_(latency), step_(static_cast<double>(step)) {
  if (!(latency.mean_sigma_s >= 0.0 && latency.jitter_s >= 0.0))
    throw std::invalid_argument("pulse counter: uncertainty of the latency must not be negative");
  if (step < 1) throw std::invalid_argument("pulse counter: step must be at least 1");
}

void CounterTrack::add(std::int64_t time_ns, std::int64_t count, std::int64_t run) noexcept {
  if (run != run_) taken_ = 0;
  run_ = run;
  const auto latency_ns = static_cast<std::int64_t>(std::llround(latency_.mean_s * 1e9));
  points_[taken_++ % kKept] = {time_ns - latency_ns, static_cast<double>(count) + 0.5 * step_};
}

std::int64_t CounterTrack::newest_ns() const noexcept {
  return taken_ == 0 ? std::numeric_limits<std::int64_t>::min() : point(taken_ - 1).time_ns;
}

std::size_t CounterTrack::behind(std::int64_t time_ns) const noexcept {
  const std::size_t kept = std::min(taken_, kKept);
  std::size_t count = 0;
  while (count < kept && point(taken_ - 1 - count).time_ns > time_ns) ++count;
  return count;
}

std::optional<CounterPosition> CounterTrack::at(std::int64_t time_ns) const noexcept {
  const std::size_t kept = std::min(taken_, kKept);
  if (kept < kPoints) return std::nullopt;
  const std::size_t oldest = taken_ - kept;
  if (time_ns < point(oldest).time_ns || time_ns > point(taken_ - 1).time_ns) return std::nullopt;
  std::size_t next = oldest;
  while (point(next).time_ns < time_ns) ++next;
  // As many before as behind, as far as there are.
  const std::size_t middle = next - oldest;
  const std::size_t first =
      oldest + std::clamp<std::size_t>(middle, kPoints / 2, kept - kPoints + kPoints / 2) - kPoints / 2;

  const Point& from = point(first);
  const double half_s = 0.5e-9 * static_cast<double>(point(first + kPoints - 1).time_ns - from.time_ns);
  const auto place = [&](std::int64_t at_ns) {
    return 1e-9 * static_cast<double>(at_ns - from.time_ns) / half_s - 1.0;
  };
  LeastSquares<2> line;
  for (std::size_t n = first; n < first + kPoints; ++n)
    line.add(place(point(n).time_ns), point(n).pulses - from.pulses);
  if (!line.solve()) return std::nullopt;
  double residual = 0.0;
  for (std::size_t n = first; n < first + kPoints; ++n) {
    const double off = point(n).pulses - from.pulses - line.value(place(point(n).time_ns));
    residual += off * off / static_cast<double>(kPoints - LeastSquares<2>::kTerms);
  }
  const double u = place(time_ns);
  constexpr double kShift = 1e-3;  // exact for a quadratic but for rounding
  CounterPosition position;
  position.pulses = from.pulses + line.value(u);
  position.rate_hz = (line.value(u + kShift) - line.value(u - kShift)) / (2.0 * kShift * half_s);
  const double jitter = position.rate_hz * latency_.jitter_s;
  const double each = std::max(residual, step_ * step_ / 12.0 + jitter * jitter);
  position.random_sigma = std::sqrt(each * line.variance(u));
  position.latency_sigma = std::abs(position.rate_hz) * latency_.mean_sigma_s;
  return position;
}

}  // namespace roadbalance
