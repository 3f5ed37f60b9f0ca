#include "common/angle/counter_angle.hpp"

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

CounterAngle::CounterAngle(std::int64_t pulses_per_turn)
    : pulses_(static_cast<double>(pulses_per_turn)), counted_(static_cast<int>(pulses_per_turn)) {
  if (pulses_per_turn < 1) throw std::invalid_argument("pulse counter: pulses_per_turn must be at least 1");
}

void CounterAngle::Place::add(double phase, const CounterPosition& position) noexcept {
  if (marks == kMemory) fade();
  ++marks;
  cosine += std::cos(phase);
  sine += std::sin(phase);
  random2 += position.random_sigma * position.random_sigma;
  latency_rate_hz += position.rate_hz;
}

void CounterAngle::Place::fade() noexcept {
  constexpr double kKept = 1.0 - 1.0 / kMemory;
  --marks;
  for (double* sum : {&cosine, &sine, &random2, &latency_rate_hz}) *sum *= kKept;
}

bool CounterAngle::mark(std::int64_t time_ns, const CounterTrack& track) noexcept {
  const auto position = track.at(time_ns);
  if (!position) return false;
  if (run_ != track.run()) {
    run_ = track.run();
    place_ = other_ = {};
    elsewhere_in_a_row_ = 0;
    counted_.forget();
    late_marks_ = 0;
  }
  if (late_marks_ == late_.size()) {
    std::copy(late_.begin() + 1, late_.end(), late_.begin());
    --late_marks_;
  }
  late_[late_marks_++] = position->pulses;
  counted_.add(position->pulses);
  const double phase = kTurn * position->pulses / pulses_;
  if (is_elsewhere(phase)) {
    hear_of_another_place(phase, *position);
    return false;
  }
  other_ = {};
  elsewhere_in_a_row_ = 0;
  place_.add(phase, *position);
  return true;
}

bool CounterAngle::is_ambiguous() const noexcept {
  if (late_marks_ < 2) return false;
  const double turns = (late_[late_marks_ - 1] - late_[0]) / pulses_;
  return static_cast<double>(late_marks_ - 1) > kMostATurn * turns;
}

std::array<int, 2> CounterAngle::mark_counts() const noexcept {
  return is_ambiguous() || !agree(place_) ? counted_.counts() : std::array<int, 2>{};
}

/// Only where the marks before agree: of a wrong number of pulses each lies elsewhere.
bool CounterAngle::is_elsewhere(double phase) const noexcept {
  if (place_.marks < kSettled || !agree(place_)) return false;
  const double off = std::remainder(phase - std::atan2(place_.sine, place_.cosine), kTurn) * pulses_ / kTurn;
  return std::abs(off) > std::max(widest_pulses(place_), 4.0 * scatter_pulses(place_));
}

void CounterAngle::hear_of_another_place(double phase, const CounterPosition& position) noexcept {
  ++elsewhere_;
  ++elsewhere_in_a_row_;
  other_.add(phase, position);
  if (other_.marks < kSettled) return;
  if (agree(other_)) {
    place_ = other_;
    elsewhere_in_a_row_ = 0;
    ++moved_;
  }
  other_ = {};
}

double CounterAngle::expected_pulses(const Place& place) noexcept {
  return place.marks == 0 ? 0.0 : std::sqrt(place.random2 / static_cast<double>(place.marks));
}

double CounterAngle::widest_pulses(const Place& place) noexcept {
  return std::max(kWidestMark_pulses, 4.0 * expected_pulses(place));
}

double CounterAngle::scatter_pulses(const Place& place) const noexcept {
  if (place.marks == 0) return 0.0;
  const double length = std::hypot(place.cosine, place.sine) / static_cast<double>(place.marks);
  return std::sqrt(-2.0 * std::log(std::clamp(length, 1e-12, 1.0))) * pulses_ / kTurn;
}

std::optional<CounterAngle::Angle> CounterAngle::at(std::int64_t time_ns,
                                                    const CounterTrack& track) const noexcept {
  if (place_.marks == 0 || run_ != track.run()) return std::nullopt;
  if (elsewhere_in_a_row_ >= kMostElsewhere || is_ambiguous() || !agree(place_)) return std::nullopt;
  const double scatter = scatter_pulses(place_), expected = expected_pulses(place_);
  const auto n = static_cast<double>(place_.marks);
  const auto position = track.at(time_ns);
  if (!position) return std::nullopt;
  const double angle =
      std::remainder(kTurn * position->pulses / pulses_ - std::atan2(place_.sine, place_.cosine), kTurn);
  // The marks came through the same latency: at the speed they passed at it cancels.
  const double mean_rate_hz = place_.latency_rate_hz / n;
  const double latency = position->rate_hz > 0.0
                             ? position->latency_sigma * std::abs(1.0 - mean_rate_hz / position->rate_hz)
                             : position->latency_sigma;
  const double mark = std::max(scatter * scatter, expected * expected) / n;
  const double random = position->random_sigma * position->random_sigma;
  return Angle{.angle_rad = angle < 0.0 ? angle + kTurn : angle,
               .sigma_rad = kTurn / pulses_ * std::sqrt(random + mark + latency * latency)};
}

}  // namespace roadbalance
