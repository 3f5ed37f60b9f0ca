#include "firmware/encoder/tooth_tracker.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {

namespace {
constexpr double kGate_pitches = 0.42;

double memory_ratio(int teeth) {
  return std::exp(-1.0 / std::max(4.0, teeth / 24.0));
}
}  // namespace

ToothTracker::ToothTracker(int teeth)
    : teeth_(teeth),
      gain_(1.0 - memory_ratio(teeth) * memory_ratio(teeth)),
      speed_gain_((1.0 - memory_ratio(teeth)) * (1.0 - memory_ratio(teeth))) {}

void ToothTracker::forget() noexcept {
  running_ = false;
  collected_ = 0;
  dropped_ = 0;
}

double ToothTracker::position(std::int64_t time_ns) const noexcept {
  return state_.position + state_.speed_per_ns * static_cast<double>(time_ns - state_.time_ns);
}

bool ToothTracker::too_long(std::int64_t time_ns) const noexcept {
  const auto silence_ns = time_ns - state_.time_ns;
  // Beyond an eighth of a turn braking could shift the count by a tooth.
  return silence_ns > kStandstill_ns ||
         static_cast<double>(silence_ns) * state_.speed_per_ns > std::max(4.0, teeth_ / 8.0);
}

ToothTracker::Outcome ToothTracker::collect(std::int64_t time_ns) noexcept {
  if (collected_ > 0) {
    const auto silence_ns = time_ns - first_[static_cast<std::size_t>(collected_ - 1)].time_ns;
    if (silence_ns <= 0) return Outcome::kStarting;
    if (silence_ns > kStandstill_ns) collected_ = 0;
  }
  first_[static_cast<std::size_t>(collected_++)].time_ns = time_ns;
  if (collected_ < kStart) return Outcome::kStarting;

  std::array<std::int64_t, kStart - 1> interval;
  for (std::size_t i = 0; i < interval.size(); ++i) interval[i] = first_[i + 1].time_ns - first_[i].time_ns;
  std::nth_element(interval.begin(), interval.begin() + interval.size() / 2, interval.end());
  const auto pitch_ns = static_cast<double>(interval[interval.size() / 2]);

  // A new run counts on from the last one, so that numbers in a history always grow.
  std::int64_t number = number_ + 1;
  first_[0].number = number;
  for (std::size_t i = 1; i < first_.size(); ++i) {
    const double pitches = static_cast<double>(first_[i].time_ns - first_[i - 1].time_ns) / pitch_ns;
    number += std::max(1L, std::lround(pitches));
    first_[i].number = number;
  }
  state_ = {time_ns, static_cast<double>(number), 1.0 / pitch_ns};
  before_ = state_;
  number_ = number_before_ = number;
  distance_ = 0.0;
  missed_ = 0;
  dropped_ = 0;
  collected_ = 0;
  running_ = true;
  return Outcome::kStarted;
}

ToothTracker::Outcome ToothTracker::add(std::int64_t time_ns, const ToothGrid& grid) noexcept {
  if (!running_) return collect(time_ns);
  if (too_long(time_ns)) {
    forget();
    collect(time_ns);
    return Outcome::kLost;
  }
  const double predicted = position(time_ns);
  std::int64_t nearest = std::llround(predicted);
  double distance = grid.position(nearest) - predicted;
  for (const std::int64_t other : {nearest - 1, nearest + 1}) {
    const double d = grid.position(other) - predicted;
    if (std::abs(d) < std::abs(distance)) {
      nearest = other;
      distance = d;
    }
  }
  const bool again = nearest == number_;
  if (std::abs(distance) > kGate_pitches || nearest < number_ ||
      (again && std::abs(distance) >= std::abs(distance_))) {
    if (++dropped_ <= std::max(8, teeth_ / 12)) return Outcome::kDropped;
    forget();
    collect(time_ns);
    return Outcome::kLost;
  }
  if (again) {  // what was taken for this tooth was none: step back and take this pulse
    state_ = before_;
    number_ = number_before_;
    distance = grid.position(nearest) - position(time_ns);
  }
  before_ = state_;
  number_before_ = number_;
  const auto steps = static_cast<double>(std::max<std::int64_t>(1, nearest - number_));
  missed_ = nearest - number_ - 1;
  const double here = position(time_ns);
  const double speed = state_.speed_per_ns;
  state_ = {time_ns, here + gain_ * distance, speed + speed_gain_ * distance * speed / steps};
  number_ = nearest;
  distance_ = distance;
  dropped_ = 0;
  if (!(state_.speed_per_ns > 0.0)) {
    forget();
    return Outcome::kLost;
  }
  return again ? Outcome::kReplaces : Outcome::kNumbered;
}

}  // namespace roadbalance
