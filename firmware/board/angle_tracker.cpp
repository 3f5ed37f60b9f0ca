#include "firmware/board/angle_tracker.hpp"

#include <algorithm>

namespace roadbalance::board {
namespace {

constexpr float kTurn = 4294967296.0f;
constexpr float kTwoPi = 6.2831853f;

// A wheel that stands for half a second has stopped: its speed begins anew.
constexpr std::uint32_t kStillsPerSecond = 2;

// So many teeth missing in a row: the wheel does something else than predicted.
constexpr float kMissingTeeth = 4.5f;

// As the analyser's own numbering: a pulse further from every tooth is none.
constexpr float kFarthestPitches = 0.42f;

// The mark's place is the mean of the last ones.
constexpr std::uint32_t kAveragedMarks = 8;
constexpr std::uint32_t kStrangeMarks = 3;
constexpr std::uint32_t kFarthestMark = 1u << 29;  // 1/8 of a turn

/// A float of nearly half a turn may be a whole half, which no signed angle holds.
std::int32_t angle_of(float value) {
  return static_cast<std::int32_t>(std::clamp(value, -kTurn / 2, kTurn / 2 * 0.999f));
}

constexpr std::uint32_t magnitude(std::int32_t angle) {
  const auto bits = static_cast<std::uint32_t>(angle);
  return angle < 0 ? 0u - bits : bits;
}

}  // namespace

void AngleTracker::start(const Setup& setup) {
  *this = {};
  setup_ = setup;
  step_ = UINT64_MAX / setup.pulses_per_turn;
  pitch_ = static_cast<std::int32_t>(step_ >> 32);
}

Phase AngleTracker::place(std::int32_t number) const {
  return static_cast<Phase>((static_cast<std::uint64_t>(number) * step_) >> 32);
}

std::int32_t AngleTracker::wrapped(std::int32_t number) const {
  const auto pulses = static_cast<std::int32_t>(setup_.pulses_per_turn);
  number %= pulses;
  return number < 0 ? number + pulses : number;
}

std::int32_t AngleTracker::teeth_in(std::int32_t angle) const {
  const auto pitch = static_cast<std::uint32_t>(pitch_);
  const auto teeth = static_cast<std::int32_t>((magnitude(angle) + pitch / 2) / pitch);
  return angle < 0 ? -teeth : teeth;
}

std::int32_t AngleTracker::without(std::int32_t angle, std::int32_t teeth) const {
  return static_cast<std::int32_t>(static_cast<Phase>(angle) -
                                   static_cast<Phase>(teeth) * static_cast<Phase>(pitch_));
}

void AngleTracker::leave(std::int32_t passed, bool forward) {
  number_ = forward ? passed : wrapped(passed - 1);
}

Phase AngleTracker::carried(std::uint64_t ticks) const {
  const float later = static_cast<float>(static_cast<std::uint32_t>(ticks - ticks_));
  return phase_ + static_cast<Phase>(angle_of(speed_ * later));
}

void AngleTracker::begin(std::uint64_t ticks, Phase measured) {
  ticks_ = ticks;
  phase_ = measured;
  speed_ = 0.0f;
  teeth_ = 1;
  good_ = 0;
  // Without a sense of direction it is not known where the wheel came to rest.
  marks_ = 0;
}

void AngleTracker::tooth(std::uint64_t ticks, bool forward) {
  // A flank passed backward is the one that was passed forward to come to this number.
  const std::int32_t passed = forward ? wrapped(number_ + 1) : number_;
  const std::uint64_t later = ticks - ticks_;
  if (teeth_ == 0 || later > setup_.tick_hz / kStillsPerSecond || (follows() && is_overdue(ticks))) {
    leave(passed, forward);
    return begin(ticks, place(passed));
  }
  if (later == 0) return;
  if (teeth_ == 1) {
    leave(passed, forward);
    const auto pitch = static_cast<float>(forward ? pitch_ : -pitch_);
    speed_ = pitch / static_cast<float>(static_cast<std::uint32_t>(later));
    phase_ = place(passed);
    ticks_ = ticks;
    teeth_ = 2;
    return;
  }
  const Phase predicted = carried(ticks);
  const auto error = static_cast<std::int32_t>(place(passed) - predicted);
  // Just begun, or turning back, the prediction is worth less than the count.
  if (follows() && forward == (speed_ > 0.0f)) return nearest(ticks, predicted, passed, error);
  leave(passed, forward);
  good_ = magnitude(error) > static_cast<std::uint32_t>(pitch_ / 4) ? 0 : std::min(good_ + 1, kGoodTeeth);
  filter(ticks, predicted, error);
}

void AngleTracker::nearest(std::uint64_t ticks, Phase predicted, std::int32_t passed, std::int32_t error) {
  const bool forward = speed_ > 0.0f;
  const std::int32_t slip = teeth_in(error);
  const std::int32_t remainder = without(error, slip);
  const bool same_again = slip == (forward ? 1 : -1);
  if (same_again || static_cast<float>(magnitude(remainder)) > kFarthestPitches * static_cast<float>(pitch_))
    return;
  leave(wrapped(passed - slip), forward);
  filter(ticks, predicted, remainder);
}

void AngleTracker::filter(std::uint64_t ticks, Phase predicted, std::int32_t error) {
  const auto later = static_cast<float>(static_cast<std::uint32_t>(ticks - ticks_));
  const float x = kTwoPi * setup_.corner_hz * later / static_cast<float>(setup_.tick_hz);
  const float q = x * (1.0f + x * (0.5f + x / 6));
  const float r = 1.0f / (1.0f + q);
  const float remainder = q * r;  // 1 - r
  const auto wrong = static_cast<float>(error);
  ticks_ = ticks;
  phase_ = predicted + static_cast<Phase>(angle_of(remainder * (1.0f + r) * wrong));
  speed_ += remainder * remainder * wrong / later;
}

void AngleTracker::zero_mark(std::uint64_t ticks) {
  if (!setup_.zero_mark || !follows()) return;
  const Phase here = carried(ticks);
  const auto error = static_cast<std::int32_t>(here + zero_);
  if (marks_ == 0 || strange_ >= kStrangeMarks) {
    zero_ = Phase{0} - here;
    marks_ = 1;
    strange_ = 0;
    return;
  }
  if (magnitude(error) > kFarthestMark) {
    ++strange_;
    return;
  }
  strange_ = 0;
  marks_ = std::min(marks_ + 1, kAveragedMarks);
  // A whole tooth is one that was miscounted; the remainder is the mark's own scatter.
  const std::int32_t remainder = without(error, teeth_in(error));
  const std::int32_t scatter = remainder / static_cast<std::int32_t>(marks_);
  zero_ -= static_cast<Phase>(error) - static_cast<Phase>(remainder) + static_cast<Phase>(scatter);
}

bool AngleTracker::locked(std::uint64_t ticks) const {
  if (!follows() || (setup_.zero_mark && marks_ == 0)) return false;
  const std::uint64_t later = ticks - ticks_;
  if (later > setup_.tick_hz / kStillsPerSecond) return false;
  return !is_overdue(ticks);
}

bool AngleTracker::is_overdue(std::uint64_t ticks) const {
  const float moved = speed_ * static_cast<float>(static_cast<std::uint32_t>(ticks - ticks_));
  const float limit = kMissingTeeth * static_cast<float>(pitch_);
  return moved > limit || moved < -limit;
}

}  // namespace roadbalance::board
