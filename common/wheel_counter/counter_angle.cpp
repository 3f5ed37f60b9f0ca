#include "common/wheel_counter/counter_angle.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace roadbalance {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

}  // namespace

CounterForm of_ring(CounterForm form, std::int64_t pulses_per_turn) {
  const auto pulses = static_cast<double>(pulses_per_turn);
  form.highest_rate_hz = std::max(form.highest_rate_hz, 45.0 * pulses);
  form.highest_change_hz_s = std::max(form.highest_change_hz_s, 12.0 * pulses);
  return form;
}

CounterAngle::CounterAngle(std::int64_t pulses_per_turn) : pulses_(static_cast<double>(pulses_per_turn)) {
  if (pulses_per_turn < 1) throw std::invalid_argument("pulse counter: pulses_per_turn must be at least 1");
}

bool CounterAngle::mark(std::int64_t time_ns, const CounterTrack& track) noexcept {
  const auto position = track.at(time_ns);
  if (!position) return false;
  if (run_ != track.run()) {
    *this = CounterAngle(static_cast<std::int64_t>(pulses_));
    run_ = track.run();
  }
  const double phase = kTurn * position->pulses / pulses_;
  if (is_false(phase)) {
    if (++false_in_a_row_ < kSettled) return false;
    *this = CounterAngle(static_cast<std::int64_t>(pulses_));
    run_ = track.run();
  }
  false_in_a_row_ = 0;
  cosine_ += std::cos(phase);
  sine_ += std::sin(phase);
  random2_ += position->random_sigma * position->random_sigma;
  latency_rate_hz_ += position->rate_hz;
  ++marks_;
  return true;
}

/// Only where the marks before agree: of a wrong number of pulses each lies elsewhere.
bool CounterAngle::is_false(double phase) const noexcept {
  const double widest = std::max(kWidestMark_pulses, 4.0 * expected_pulses());
  if (marks_ < kSettled || scatter_pulses() > widest) return false;
  const double off = std::remainder(phase - std::atan2(sine_, cosine_), kTurn) * pulses_ / kTurn;
  return std::abs(off) > std::max(widest, 4.0 * scatter_pulses());
}

double CounterAngle::expected_pulses() const noexcept {
  return marks_ == 0 ? 0.0 : std::sqrt(random2_ / static_cast<double>(marks_));
}

double CounterAngle::scatter_pulses() const noexcept {
  if (marks_ == 0) return 0.0;
  const double length = std::hypot(cosine_, sine_) / static_cast<double>(marks_);
  return std::sqrt(-2.0 * std::log(std::clamp(length, 1e-12, 1.0))) * pulses_ / kTurn;
}

std::optional<CounterAngle::Angle> CounterAngle::at(std::int64_t time_ns,
                                                    const CounterTrack& track) const noexcept {
  if (marks_ == 0 || run_ != track.run()) return std::nullopt;
  const double scatter = scatter_pulses();
  const auto n = static_cast<double>(marks_);
  const double expected = expected_pulses();
  if (scatter > std::max(kWidestMark_pulses, 4.0 * expected)) return std::nullopt;
  const auto position = track.at(time_ns);
  if (!position) return std::nullopt;
  const double angle = std::remainder(kTurn * position->pulses / pulses_ - std::atan2(sine_, cosine_), kTurn);
  // The marks came through the same latency: at the speed they passed at it cancels.
  const double mean_rate_hz = latency_rate_hz_ / n;
  const double latency = position->rate_hz > 0.0
                             ? position->latency_sigma * std::abs(1.0 - mean_rate_hz / position->rate_hz)
                             : position->latency_sigma;
  const double mark = std::max(scatter * scatter, expected * expected) / n;
  const double random = position->random_sigma * position->random_sigma;
  return Angle{.angle_rad = angle < 0.0 ? angle + kTurn : angle,
               .sigma_rad = kTurn / pulses_ * std::sqrt(random + mark + latency * latency)};
}

}  // namespace roadbalance
