#include "common/angle/tooth_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/angle/least_squares.hpp"

namespace roadbalance {

namespace {
constexpr double kGate_pitches = 0.42;

constexpr double kLag_pitches = 0.1;
constexpr double kTorsion_rad_s2 = 116.0;     // 1 degree at 13 Hz
constexpr double kLeastMemory_pitches = 1.5;  // when slow: then jitter is nothing and a start or stop is all
constexpr double kStraight_pitches = 0.25;
constexpr double kFaultMemory_pulses = 64.0, kMostFaults = 24.0;
constexpr double kJitter_pitches = 0.1;  // 1 of 40 000 stamps that scatter so little leaves its gate
// Where stamps scatter by 0.2 of a pitch and 1 % of the teeth are lost, one so far off is still likelier to
// be the next tooth than the one beside it; but not right after a pulse that was none or a tooth without one:
// those may have been it.
constexpr double kJitterGate_pitches = 0.65;
constexpr std::int64_t kOutOfStep_teeth = 2;
constexpr double kJitterMemory_pulses = 64.0;
constexpr double kStartMemory_pitches = 4.0, kMemoryGrowth_pitches = 0.5;
}  // namespace

// In steady acceleration a the filter lags a memory^2.
ToothTracker::ToothTracker(int teeth)
    : teeth_(teeth),
      longest_memory_ns_(1e9 * std::sqrt(kLag_pitches * 2.0 * std::numbers::pi / teeth / kTorsion_rad_s2)) {}

void ToothTracker::forget() noexcept {
  running_ = false;
  collected_ = 0;
  dropped_ = 0;
}

double ToothTracker::position(std::int64_t time_ns) const noexcept {
  return state_.position + state_.speed_per_ns * static_cast<double>(time_ns - state_.time_ns);
}

bool ToothTracker::jitters() const noexcept {
  return distance_square_ > kJitter_pitches * kJitter_pitches;
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

  number_first_pulses();
  missed_ = 0;
  dropped_ = 0;
  collected_ = 0;
  running_ = true;
  return Outcome::kStarted;
}

/// An interval is as many pitches as it is long against the middle one and against the next: the one alone
/// would see two in the first of a wheel that starts, the other in one after a pulse too many.
void ToothTracker::number_first_pulses() noexcept {
  std::array<double, kStart - 1> interval_ns;
  for (std::size_t i = 0; i < interval_ns.size(); ++i)
    interval_ns[i] = static_cast<double>(first_[i + 1].time_ns - first_[i].time_ns);
  auto sorted = interval_ns;
  std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
  const double middle_ns = sorted[sorted.size() / 2];
  std::array<std::int64_t, kStart - 1> pitches;
  double next_ns = middle_ns;
  for (std::size_t i = interval_ns.size(); i-- > 0;) {
    pitches[i] = std::max(1L, std::lround(interval_ns[i] / std::max(middle_ns, next_ns)));
    next_ns = interval_ns[i] / static_cast<double>(pitches[i]);
  }
  // A new run counts on from the last one, so that numbers in a history always grow.
  first_[0].number = number_ + 1;
  for (std::size_t i = 0; i < pitches.size(); ++i) first_[i + 1].number = first_[i].number + pitches[i];

  // A quadratic: a wheel that starts doubles its speed meanwhile.
  const std::int64_t end_ns = first_.back().time_ns, number = first_.back().number;
  const double half_ns = 0.5 * static_cast<double>(end_ns - first_[0].time_ns);
  LeastSquares<2> motion;
  for (const NumberedTooth& tooth : first_)
    motion.add(static_cast<double>(tooth.time_ns - end_ns) / half_ns + 1.0,
               static_cast<double>(tooth.number - number));
  state_ = {end_ns, static_cast<double>(number), 1.0 / middle_ns};
  double square = 0.0;
  const bool solved = motion.solve();
  for (const NumberedTooth& tooth : first_) {
    const double u = static_cast<double>(tooth.time_ns - end_ns) / half_ns + 1.0;
    square += std::pow(static_cast<double>(tooth.number - number) - motion.value(u), 2) / kStart;
  }
  if (solved && square < kStraight_pitches * kStraight_pitches && motion.slope_at_end() > 0.0)
    state_ = {end_ns, static_cast<double>(number) + motion.value(1.0), motion.slope_at_end() / half_ns};
  before_ = state_;
  number_ = number_before_ = in_step_from_ = number;
  distance_ = distance_square_ = 0.0;
  faults_ = 0.0;
  memory_pitches_ = std::min(kStartMemory_pitches, longest_memory_ns_ * state_.speed_per_ns);
}

void ToothTracker::count_fault(bool fault) noexcept {
  faults_ += (fault ? 1.0 : 0.0) - faults_ / kFaultMemory_pulses;
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
  double gate = kGate_pitches;
  if (const double d = grid.position(number_ + 1) - predicted;
      jitters() && number_ >= in_step_from_ && std::abs(d) < kJitterGate_pitches) {
    nearest = number_ + 1;
    distance = d;
    gate = kJitterGate_pitches;
  }
  const bool again = nearest == number_;
  if (std::abs(distance) > gate || nearest < number_ ||
      (again && std::abs(distance) >= std::abs(distance_))) {
    count_fault(true);
    in_step_from_ = number_ + kOutOfStep_teeth;
    if (++dropped_ <= std::max(8, teeth_ / 12) && faults_ < kMostFaults) return Outcome::kDropped;
    forget();
    collect(time_ns);
    return Outcome::kLost;
  }
  if (again) {  // what was taken for this tooth was none: step back and take this pulse
    in_step_from_ = number_ + kOutOfStep_teeth;
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
  memory_pitches_ = std::clamp(memory_pitches_ + kMemoryGrowth_pitches, kLeastMemory_pitches,
                               std::max(kLeastMemory_pitches, longest_memory_ns_ * speed));
  const double fading = 1.0 - std::exp(-1.0 / memory_pitches_);
  state_ = {time_ns, here + fading * (2.0 - fading) * distance,
            speed + fading * fading * distance * speed / steps};
  number_ = nearest;
  if (missed_ > 0) in_step_from_ = number_ + kOutOfStep_teeth;
  distance_ = distance;
  distance_square_ += (distance * distance - distance_square_) / kJitterMemory_pulses;
  dropped_ = 0;
  count_fault(missed_ > 0);
  if (!(state_.speed_per_ns > 0.0) || faults_ >= kMostFaults) {
    forget();
    return Outcome::kLost;
  }
  return again ? Outcome::kReplaces : Outcome::kNumbered;
}

}  // namespace roadbalance
