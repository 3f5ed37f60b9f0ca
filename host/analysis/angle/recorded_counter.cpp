#include "host/analysis/angle/recorded_counter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/angle/counter_angle.hpp"
#include "common/angle/counter_unwrap.hpp"
#include "common/types/angle_units.hpp"
#include "host/analysis/angle/mark_place.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kCounterStretch_ns = 30'000'000'000, kCounterOverlap_ns = 3'000'000'000;
constexpr std::size_t kLeastPoints = 16;
constexpr std::size_t kRateOver = 8;  // messages on either side

/// A constant speed may make every count of a stretch round the same way, unless jitter shakes it: by the
/// first harmonic of the sawtooth that rounding is.
double locked_rounding(double step, double jitter_pulses) {
  return step / std::sqrt(12.0) * std::exp(-2.0 * std::pow(std::numbers::pi * jitter_pulses / step, 2));
}

double mean_rate_hz(const WheelPoint& a, const WheelPoint& b) {
  return (b.position - a.position) * 1e9 / static_cast<double>(b.time_ns - a.time_ns);
}

}  // namespace

RecordedCounter::RecordedCounter(const EncoderConfig& config, const SignalConfig& counter,
                                 std::span<const SignalSample> samples, std::span<const Edge> edges)
    : config_(config), counter_(counter) {
  unwrap(samples);
  for (std::size_t k = 0; k < runs_.size(); ++k) split(k, edges);
  drop_short_runs();
  for (Run& run : runs_) place_marks(run, edges);
}

void RecordedCounter::unwrap(std::span<const SignalSample> samples) {
  CounterUnwrap counter(of_ring(counter_.counter, config_.pulses_per_turn));
  const auto latency_ns = std::llround(1e9 * counter_.latency.mean_s);
  const double half = 0.5 * static_cast<double>(counter_.counter.step);
  for (const SignalSample& sample : samples) {
    if (!(std::abs(sample.value) < 1e15)) continue;
    const auto outcome = counter.take(to_ns(sample.time), std::llround(sample.value));
    if (outcome == CounterUnwrap::Outcome::kInvalid || outcome == CounterUnwrap::Outcome::kOutOfOrder)
      continue;
    if (outcome != CounterUnwrap::Outcome::kJoined) runs_.emplace_back();
    runs_.back().points.push_back(
        {to_ns(sample.time) - latency_ns, static_cast<double>(counter.count()) + half, 1.0});
  }
  drop_short_runs();
}

void RecordedCounter::drop_short_runs() {
  std::erase_if(runs_, [](const Run& run) { return run.points.size() < kLeastPoints; });
  smoothed_ = nullptr;
}

/// Over a few messages about the instant.
double RecordedCounter::rate_hz(const Run& run, std::int64_t time_ns) const {
  const auto here = std::ranges::lower_bound(run.points, time_ns, {}, &WheelPoint::time_ns);
  const auto at = static_cast<std::size_t>(here - run.points.begin());
  const std::size_t a = at - std::min(at, kRateOver), b = std::min(at + kRateOver, run.points.size() - 1);
  return mean_rate_hz(run.points[a], run.points[b]);
}

bool RecordedCounter::smooth(const Run& run, std::int64_t from_ns, std::int64_t to_ns) {
  from_ns_ = from_ns;
  to_ns_ = to_ns;
  const auto begin =
      std::ranges::lower_bound(run.points, from_ns - kCounterOverlap_ns, {}, &WheelPoint::time_ns);
  const auto end = std::ranges::upper_bound(run.points, to_ns + kCounterOverlap_ns, {}, &WheelPoint::time_ns);
  const std::vector<WheelPoint> points(begin, end);
  const auto step = static_cast<double>(counter_.counter.step);
  if (points.size() < kLeastPoints) return false;
  const double jitter = mean_rate_hz(points.front(), points.back()) * counter_.latency.jitter_s;
  noise_ = step * step / 12.0 + jitter * jitter;
  if (!smoother_.smooth(points, noise_)) return false;
  // Messages that jitter by more than configured show it in what the smoother leaves.
  double left = 0.0;
  for (const WheelPoint& point : points)
    left += std::pow(point.position - smoother_.position(point.time_ns), 2);
  left /= static_cast<double>(points.size());
  if (left <= noise_) return true;
  noise_ = left;
  return smoother_.smooth(points, noise_);
}

const RecordedCounter::Run* RecordedCounter::prepare(std::int64_t from_ns, std::int64_t to_ns) {
  if (smoothed_ && from_ns_ <= from_ns && to_ns <= to_ns_) return smoothed_;
  for (const Run& run : runs_) {
    const std::int64_t begin_ns = run.points.front().time_ns, end_ns = run.points.back().time_ns;
    if (from_ns < begin_ns || to_ns > end_ns) continue;
    smoothed_ = nullptr;
    if (!smooth(run, from_ns, std::min(end_ns, std::max(from_ns + kCounterStretch_ns, to_ns))))
      return nullptr;
    smoothed_ = &run;
    return smoothed_;
  }
  return nullptr;
}

RecordedCounter::Marks RecordedCounter::marks_of(const Run& run, std::span<const Edge> edges) {
  Marks marks;
  double noise = 0.0;
  for (const Edge& edge : edges) {
    const std::int64_t time_ns = to_ns(edge.time);
    if (edge.kind != EdgeKind::kZeroMark || time_ns < run.points.front().time_ns ||
        time_ns > run.points.back().time_ns)
      continue;
    if (prepare(time_ns, time_ns) != &run) continue;
    marks.mark.push_back({time_ns, smoother_.position(time_ns), rate_hz(run, time_ns)});
    noise += std::pow(smoother_.sigma(time_ns), 2);
    marks.bandwidth_hz += smoother_.bandwidth_hz();
  }
  const auto all = static_cast<double>(std::max<std::size_t>(marks.mark.size(), 1));
  marks.noise = noise / all;
  marks.bandwidth_hz /= all;
  marks.widest = std::max(CounterAngle::kWidestMark_pulses, 4.0 * std::sqrt(marks.noise));
  return marks;
}

/// Messages between the marks on either side of the loss belong to neither.
void RecordedCounter::split(std::size_t run, std::span<const Edge> edges) {
  if (!config_.zero_mark) return;
  const Marks marks = marks_of(runs_[run], edges);
  const auto moved = first_move(marks.mark, config_.pulses_per_turn, marks.widest);
  if (!moved) return;
  auto& points = runs_[run].points;
  const auto end = std::ranges::upper_bound(points, moved->before_ns, {}, &WheelPoint::time_ns);
  const auto begin = std::ranges::lower_bound(points, moved->behind_ns, {}, &WheelPoint::time_ns);
  Run behind;
  behind.points.assign(begin, points.end());
  points.erase(end, points.end());
  runs_.insert(runs_.begin() + static_cast<std::ptrdiff_t>(run) + 1, std::move(behind));
  smoothed_ = nullptr;
}

void RecordedCounter::place_marks(Run& run, std::span<const Edge> edges) {
  if (!config_.zero_mark) return;
  const double pulses = config_.pulses_per_turn;
  auto [marks, noise, bandwidth_hz, widest] = marks_of(run, edges);
  if (marks.empty()) return;
  run.place = densest_place(marks, pulses, widest);
  const auto is_elsewhere = [&, most = widest](const PlacedMark& mark) {
    return std::abs(std::remainder(mark.position - run.place, pulses)) > most;
  };
  run.dropped = static_cast<std::int64_t>(std::erase_if(marks, is_elsewhere));
  run.marks = static_cast<std::int64_t>(marks.size());
  // Fewer than half in one place: the number of pulses is wrong, or these are no marks.
  if (run.marks <= run.dropped) return;
  run.placed = true;
  run.place = mean_place(marks, pulses);
  for (const PlacedMark& mark : marks) run.mark_rate_hz += mark.rate_hz / static_cast<double>(run.marks);
  // Marks within the smoother's memory see the same error of the count.
  const double seconds = 1e-9 * static_cast<double>(run.points.back().time_ns - run.points.front().time_ns);
  const double independent = std::clamp(seconds * bandwidth_hz, 1.0, static_cast<double>(run.marks));
  run.place_sigma =
      std::max(scatter_about(marks, run.place, pulses), std::sqrt(noise)) / std::sqrt(independent);
}

const RecordedCounter::Run* RecordedCounter::look_up(NodeTime first, double step_ns,
                                                     std::span<double> angle_rad) {
  const auto instant = [&](std::size_t i) {
    return to_ns(first) + std::llround(static_cast<double>(i) * step_ns);
  };
  if (angle_rad.empty()) return nullptr;
  const Run* const run = prepare(instant(0), instant(angle_rad.size() - 1));
  if (!run) return nullptr;
  const double pulse_rad = kTurn / config_.pulses_per_turn;
  for (std::size_t i = 0; i < angle_rad.size(); ++i)
    angle_rad[i] = smoother_.position(instant(i)) * pulse_rad;
  return run;
}

bool RecordedCounter::turned(NodeTime first, double step_ns, std::span<double> angle_rad) {
  return look_up(first, step_ns, angle_rad) != nullptr;
}

bool RecordedCounter::angles(NodeTime first, double step_ns, std::span<double> angle_rad) {
  const Run* const run = look_up(first, step_ns, angle_rad);
  if (!run || !run->placed) return false;
  const double pulse_rad = kTurn / config_.pulses_per_turn;
  for (double& angle : angle_rad) angle += config_.datum_rad - run->place * pulse_rad;
  const double rate = rate_hz(*run, to_ns(first)), jitter = rate * counter_.latency.jitter_s;
  const double latency = (rate - run->mark_rate_hz) * counter_.latency.mean_sigma_s;
  const double rounding = locked_rounding(static_cast<double>(counter_.counter.step), jitter);
  sigma_rad_ = pulse_rad * std::hypot(std::hypot(smoother_.sigma(to_ns(first)), rounding),
                                      std::hypot(run->place_sigma, latency));
  return true;
}

std::optional<double> RecordedCounter::common_sigma_rad() const {
  double square = 0.0, weight = 0.0;
  for (const Run& run : runs_) {
    if (!run.placed) continue;
    const double length = static_cast<double>(run.points.size());
    // Its mean over the run: the rest averages out.
    const double mean_hz = mean_rate_hz(run.points.front(), run.points.back());
    const double latency = (mean_hz - run.mark_rate_hz) * counter_.latency.mean_sigma_s;
    square += length * (run.place_sigma * run.place_sigma + latency * latency);
    weight += length;
  }
  if (weight == 0.0) return std::nullopt;
  return kTurn / config_.pulses_per_turn * std::sqrt(square / weight);
}

std::int64_t RecordedCounter::marks() const {
  std::int64_t sum = 0;
  for (const Run& run : runs_) sum += run.marks;
  return sum;
}

std::int64_t RecordedCounter::marks_dropped() const {
  std::int64_t sum = 0;
  for (const Run& run : runs_) sum += run.dropped;
  return sum;
}

}  // namespace roadbalance
