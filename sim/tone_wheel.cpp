#include "sim/tone_wheel.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "common/types/angle_units.hpp"

namespace roadbalance::sim {
namespace {

/// Part of the way from `from` to `to`, 0 .. 1, at which the position is `place_m`, which lies between.
double solve(const ToneWheel::Instant& from, const ToneWheel::Instant& to, double place_m) {
  const double step_s = to.time_s - from.time_s;
  const double way_m = to.motion.position_m - from.motion.position_m;
  const double a = step_s * from.motion.speed_m_s;
  const double b = step_s * to.motion.speed_m_s;
  const double c2 = 3.0 * way_m - 2.0 * a - b;
  const double c3 = a + b - 2.0 * way_m;
  const double target_m = place_m - from.motion.position_m;
  double x = target_m / way_m;
  // Newton; the speed hardly changes within a scan, so three passes reach rounding.  Clamped for a car that
  // stops.
  for (int i = 0; i < 3; ++i) {
    const double slope = a + x * (2.0 * c2 + 3.0 * x * c3);
    if (!(slope > 0.0)) break;
    x = std::clamp(x - (x * (a + x * (c2 + x * c3)) - target_m) / slope, 0.0, 1.0);
  }
  return x;
}

std::vector<double> draw_positions(const EncoderScenario& scenario, std::uint64_t seed, std::size_t wheel,
                                   int pulses) {
  const RandomSequence random(seed, Use::kPitchError, wheel);
  const double pitch_rad = kTurn / pulses;
  const double off_centre_rad = kTurn * random.uniform(-1);
  std::vector<double> error(static_cast<std::size_t>(pulses));
  double mean = 0.0;
  for (std::size_t n = 0; n < error.size(); ++n) {
    error[n] = scenario.pitch_error_pitches * pitch_rad * random.normal(static_cast<std::int64_t>(n)) +
               scenario.eccentricity_rad * std::sin(pitch_rad * static_cast<double>(n) + off_centre_rad);
    mean += error[n] / pulses;
  }
  for (std::size_t n = 0; n < error.size(); ++n)
    error[n] += pitch_rad * (static_cast<double>(n) + scenario.tooth_offset_pitches) - mean;
  return error;
}

}  // namespace

void EdgeQueue::insert(const Edge& edge) {
  if (edge_.size() == edge_.capacity()) {  // never grows: make room where edges were taken
    edge_.erase(edge_.begin(), edge_.begin() + static_cast<std::ptrdiff_t>(first_));
    first_ = 0;
  }
  assert(edge_.size() < edge_.capacity());
  edge_.push_back(edge);
  for (std::size_t i = edge_.size() - 1; i > first_ && edge_[i].time < edge_[i - 1].time; --i)
    std::swap(edge_[i], edge_[i - 1]);
}

Edge EdgeQueue::take() {
  const Edge edge = edge_[first_++];
  if (first_ == edge_.size()) {
    edge_.clear();
    first_ = 0;
  }
  return edge;
}

ToneWheel::ToneWheel(const EncoderScenario& scenario, std::uint64_t seed, std::size_t wheel,
                     const EncoderConfig& encoder, std::uint8_t line, double rolling_radius_m,
                     double zero_angle_rad, const Instant& start)
    : pulses_(encoder.pulses_per_turn),
      zero_mark_(encoder.zero_mark),
      line_(line),
      radius_m_(rolling_radius_m),
      zero_angle_rad_(zero_angle_rad - encoder.datum_rad),
      jitter_s_(scenario.stamp_jitter_s),
      position_rad_(draw_positions(scenario, seed, wheel, encoder.pulses_per_turn)),
      tooth_{EdgeKind::kTooth, {seed, Use::kStampJitter, 2 * wheel}, 0},
      mark_{EdgeKind::kZeroMark, {seed, Use::kStampJitter, 2 * wheel + 1}, 0} {
  const double angle = start.motion.position_m / radius_m_ + zero_angle_rad_;
  const auto turn = static_cast<std::int64_t>(std::floor(angle / kTurn));
  tooth_.number = (turn - 1) * pulses_;
  mark_.number = turn - 1;
  while (angle_rad(tooth_) <= angle) ++tooth_.number;
  while (angle_rad(mark_) <= angle) ++mark_.number;
}

double ToneWheel::tooth_angle_rad(std::int64_t n) const {
  const std::int64_t tooth = ((n % pulses_) + pulses_) % pulses_;
  const std::int64_t turn = (n - tooth) / pulses_;
  return kTurn * static_cast<double>(turn) + position_rad_[static_cast<std::size_t>(tooth)];
}

double ToneWheel::angle_rad(const Kind& kind) const {
  return kind.kind == EdgeKind::kTooth ? tooth_angle_rad(kind.number)
                                       : kTurn * static_cast<double>(kind.number);
}

void ToneWheel::advance(Kind& kind, const Instant& from, const Instant& to, EdgeQueue& queue) {
  for (;; ++kind.number) {
    const double place_m = (angle_rad(kind) - zero_angle_rad_) * radius_m_;
    if (place_m > to.motion.position_m) return;
    const double time_s = from.time_s + (to.time_s - from.time_s) * solve(from, to, place_m);
    const double stamp_s = time_s + jitter_s_ * kind.jitter.normal(kind.number);
    queue.insert({node_time_from_ns(std::llround(stamp_s * 1e9)), line_, kind.kind});
  }
}

void ToneWheel::advance(const Instant& from, const Instant& to, EdgeQueue& queue) {
  advance(tooth_, from, to, queue);
  if (zero_mark_) advance(mark_, from, to, queue);
}

}  // namespace roadbalance::sim
