#include "firmware/encoder/wheel_encoder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "firmware/encoder/least_squares.hpp"

namespace roadbalance {

namespace {
constexpr int kHistoryTurns = 32;         // 0.5 s at 60 turns a second: more than a block ever waits
constexpr double kHalfWindow_ns = 7.5e6;  // beside a 10 ms block: 25 ms in all passes 13 Hz torsion to 1 %
constexpr double kPiece_ns = 10e6;        // instants that share one fit
constexpr double kLeastHalfWindow_pitches = 3.0;
constexpr std::size_t kLeastTeeth = 6;
constexpr double kStrangeMark_turns = 0.15;
constexpr std::int64_t kClearSlip_faults = 2;
constexpr std::int64_t kSealing_ns = 200'000'000;  // a block waits 100 ms for edges at most
constexpr int kMarkMemory = 100, kMarkMemoryWhileLearning = 8, kLearning_refinements = 32;
}  // namespace

WheelEncoder::WheelEncoder(const EncoderConfig& config)
    : config_(config),
      tracker_(config.pulses_per_turn),
      grid_{PitchTable(config.pulses_per_turn)},
      history_(static_cast<std::size_t>(std::max(256, kHistoryTurns * config.pulses_per_turn))) {}

void WheelEncoder::add(NodeTime time, EdgeKind kind) noexcept {
  switch (kind) {
    case EdgeKind::kTooth:
      return add_tooth(to_ns(time));
    case EdgeKind::kZeroMark:
      if (config_.zero_mark) add_mark(to_ns(time));
      return;
    case EdgeKind::kToothBackward:
      tracker_.forget();  // speed and numbers are of a wheel that went forward; a mark counts only then
      return declare_lost();
    case EdgeKind::kLost:
      return declare_lost();
  }
}

/// A turn whose teeth are known to be wrong is one fault, however often that is said.
void WheelEncoder::declare_lost() noexcept {
  if (grid_.located) {
    ++faulty_turns_;
    turn_faults_ = 1;
  }
  lose();
}

void WheelEncoder::lose() noexcept {
  grid_.located = false;
  history_.clear();
  unrefined_mark_ns_ = 0;
  suspected_slip_ = 0;
  strange_marks_ = 0;
}

void WheelEncoder::add_tooth(std::int64_t time_ns) noexcept {
  switch (tracker_.add(time_ns, grid_)) {
    case ToothTracker::Outcome::kStarting:
      return;
    case ToothTracker::Outcome::kStarted:
      for (const auto& tooth : tracker_.starting()) history_.push({tooth.time_ns, tooth.number});
      return;
    case ToothTracker::Outcome::kNumbered:
      turn_faults_ += tracker_.missed();
      history_.push({time_ns, tracker_.number()});
      break;
    case ToothTracker::Outcome::kReplaces:
      ++turn_faults_;
      history_.replace_latest({time_ns, tracker_.number()});
      break;
    case ToothTracker::Outcome::kDropped:
      ++turn_faults_;
      break;
    case ToothTracker::Outcome::kLost:
      declare_lost();
      return;
  }
  refine_mark();
  learn_if_turn_complete();
}

/// The mark names the tooth nearest to it; by its mean phase, once that is known.
void WheelEncoder::locate(std::int64_t time_ns, double position) noexcept {
  grid_.origin = std::llround(position - mark_phase_);
  if (!mark_known_) mark_phase_ = position - static_cast<double>(grid_.origin);
  mark_known_ = true;
  grid_.located = true;
  mark_turn_ = 0;
  learned_turn_ = 0;
  begin_turn(time_ns);
  suspected_slip_ = 0;
  strange_marks_ = 0;
  unrefined_mark_ns_ = time_ns;
}

void WheelEncoder::add_mark(std::int64_t time_ns) noexcept {
  if (!tracker_.running()) return;
  if (tracker_.too_long(time_ns)) {  // a place told by teeth of long ago is none
    tracker_.forget();
    return declare_lost();
  }
  const double position = tracker_.position(time_ns);
  if (!grid_.located) return locate(time_ns, position);

  const double teeth = config_.pulses_per_turn;
  const double phase = position - static_cast<double>(grid_.origin) - mark_phase_;
  const std::int64_t turn = std::llround(phase / teeth);
  const double off = phase - static_cast<double>(turn) * teeth;
  if (turn <= mark_turn_ || std::abs(off) > std::max(0.6, kStrangeMark_turns * teeth)) {
    ++turn_faults_;
    if (++strange_marks_ < 3) return;
    history_.clear();  // the marks insist: they are right and the numbers wrong
    return locate(time_ns, position);
  }
  strange_marks_ = 0;
  const std::int64_t slip = std::llround(off);
  if (slip == 0) {
    suspected_slip_ = 0;
    unrefined_mark_ns_ = time_ns;
  } else {
    ++turn_faults_;
    if (turn_faults_ > kClearSlip_faults || slip == suspected_slip_) {
      grid_.origin += slip;
      history_.clear();
      suspected_slip_ = 0;
      learned_turn_ = turn;
    } else {
      suspected_slip_ = slip;  // one mark alone may be the one at fault
    }
  }
  if (turn_faults_ > 0) ++faulty_turns_;
  mark_turn_ = turn;
  begin_turn(time_ns);
}

/// A turn with faults makes itself and the next one doubtful; an interval of them is kept until nobody asks.
void WheelEncoder::begin_turn(std::int64_t time_ns) noexcept {
  if (uncertain()) doubt_to_ns_ = time_ns;
  last_turn_faults_ = turn_faults_;
  turn_faults_ = 0;
  if (!uncertain() && time_ns > doubt_to_ns_ + kSealing_ns) doubt_from_ns_ = time_ns;
}

/// Once the teeth after a mark are there, its place in the ring is known better than by prediction.
void WheelEncoder::refine_mark() noexcept {
  if (unrefined_mark_ns_ == 0 || !grid_.located || history_.empty()) return;
  const auto mark_ns = static_cast<double>(unrefined_mark_ns_);
  if (static_cast<double>(history_.latest().time_ns) < mark_ns + half_window_ns()) return;
  unrefined_mark_ns_ = 0;
  std::array<double, 1> position;
  if (!positions(mark_ns, 0.0, position)) return;
  const double teeth = config_.pulses_per_turn;
  const double off = std::remainder(position[0] - static_cast<double>(grid_.origin) - mark_phase_, teeth);
  if (std::abs(off) > 0.5) return;
  const bool learning = grid_.table.refinements() < kLearning_refinements;
  mark_weight_ = std::min(mark_weight_ + 1, learning ? kMarkMemoryWhileLearning : kMarkMemory);
  mark_phase_ += off / mark_weight_;
}

void WheelEncoder::learn_if_turn_complete() noexcept {
  if (!grid_.located) return;
  const std::int64_t teeth = config_.pulses_per_turn;
  const std::int64_t turn = (tracker_.number() - grid_.origin) / teeth;
  if (turn <= learned_turn_) return;
  learned_turn_ = turn;
  grid_.table.learn(history_, grid_.origin + (turn - PitchTable::kTurns) * teeth, grid_.origin);
}

double WheelEncoder::half_window_ns() const noexcept {
  return std::max(kHalfWindow_ns, kLeastHalfWindow_pitches * tracker_.pitch_ns());
}

NodeTime WheelEncoder::complete_at(NodeTime last) const noexcept {
  if (!tracker_.running()) return last;
  return last + NodeClock::duration(static_cast<std::int64_t>(half_window_ns()));
}

std::optional<WheelEncoder::Window> WheelEncoder::window(double from_ns, double to_ns) const noexcept {
  if (!tracker_.running()) return std::nullopt;
  const double half_ns = half_window_ns();
  const Window teeth{history_.first_at(static_cast<std::int64_t>(from_ns - half_ns)),
                     history_.first_at(static_cast<std::int64_t>(to_ns + half_ns))};
  if (teeth.end - teeth.begin < kLeastTeeth) return std::nullopt;
  const NumberedTooth& first = history_[teeth.begin];
  const NumberedTooth& last = history_[teeth.end - 1];
  // Outside the teeth only as far as the next one could be.
  const double reach_ns = 1.5 * static_cast<double>(last.time_ns - first.time_ns) /
                          static_cast<double>(last.number - first.number);
  if (from_ns < static_cast<double>(first.time_ns) - reach_ns ||
      to_ns > static_cast<double>(last.time_ns) + reach_ns)
    return std::nullopt;
  return teeth;
}

namespace {

/// Cubic through the teeth [begin, end); again without those far off, which were no teeth.
struct LocalFit {
  LeastSquares<3> cubic;
  double centre_ns, half_ns, origin;

  double scaled(double time_ns) const noexcept { return (time_ns - centre_ns) / half_ns; }
  double position(double time_ns) const noexcept { return origin + cubic.value(scaled(time_ns)); }

  bool fit(const ToothHistory& history, const ToothGrid& grid, std::size_t begin, std::size_t end) noexcept {
    const auto first_ns = static_cast<double>(history[begin].time_ns);
    const auto last_ns = static_cast<double>(history[end - 1].time_ns);
    centre_ns = 0.5 * (first_ns + last_ns);
    half_ns = 0.5 * (last_ns - first_ns);
    origin = static_cast<double>(history[begin].number);
    const auto u = [&](std::size_t i) { return scaled(static_cast<double>(history[i].time_ns)); };
    const auto y = [&](std::size_t i) { return grid.position(history[i].number) - origin; };

    LeastSquares<3> all;
    for (std::size_t i = begin; i < end; ++i) all.add(u(i), y(i));
    if (!all.solve()) return false;
    cubic = all;
    double square = 0.0, largest = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const double residual = y(i) - all.value(u(i));
      square += residual * residual;
      largest = std::max(largest, residual * residual);
    }
    const double limit = 3.5 * 3.5 * square / static_cast<double>(end - begin);
    if (largest <= limit) return true;
    std::size_t kept = 0;
    LeastSquares<3> good;
    for (std::size_t i = begin; i < end; ++i) {
      const double residual = y(i) - all.value(u(i));
      if (residual * residual > limit) continue;
      good.add(u(i), y(i));
      ++kept;
    }
    if (kept >= kLeastTeeth && good.solve()) cubic = good;
    return true;
  }
};

}  // namespace

bool WheelEncoder::positions(double first_ns, double step_ns, std::span<double> position) const noexcept {
  const double piece_ns = std::max(kPiece_ns, 2.0 * kLeastHalfWindow_pitches * tracker_.pitch_ns());
  const std::size_t piece = step_ns > 0.0
                                ? std::max<std::size_t>(1, static_cast<std::size_t>(piece_ns / step_ns))
                                : position.size();
  for (std::size_t begin = 0; begin < position.size(); begin += piece) {
    const std::size_t end = std::min(begin + piece, position.size());
    const auto instant = [&](std::size_t i) { return first_ns + static_cast<double>(i) * step_ns; };
    const auto teeth = window(instant(begin), instant(end - 1));
    LocalFit local;
    if (!teeth || !local.fit(history_, grid_, teeth->begin, teeth->end)) return false;
    for (std::size_t i = begin; i < end; ++i) position[i] = local.position(instant(i));
  }
  return true;
}

bool WheelEncoder::angles(NodeTime first, double step_ns, std::span<double> angle_rad) const noexcept {
  if (!grid_.located || !positions(static_cast<double>(to_ns(first)), step_ns, angle_rad)) return false;
  const double pitch_rad = 2.0 * std::numbers::pi / config_.pulses_per_turn;
  for (double& angle : angle_rad)
    angle = (angle - static_cast<double>(grid_.origin) - mark_phase_) * pitch_rad + config_.datum_rad;
  return true;
}

double WheelEncoder::speed_rad_s(NodeTime now) const noexcept {
  if (!tracker_.running() || history_.empty()) return 0.0;
  if (to_ns(now) - history_.latest().time_ns > ToothTracker::kStandstill_ns) return 0.0;
  return 2.0 * std::numbers::pi / config_.pulses_per_turn / tracker_.pitch_ns() * 1e9;
}

}  // namespace roadbalance
