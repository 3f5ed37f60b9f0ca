#include "common/angle/wheel_encoder.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/angle/own_mark.hpp"

namespace roadbalance {

namespace {
constexpr int kHistoryTurns = 2 * PitchTable::kTurns;
constexpr std::int64_t kFollowAgain_ns = 250'000'000;
constexpr std::int64_t kSealing_ns = 200'000'000;  // a block waits 100 ms for edges at most
constexpr int kLearning_refinements = 32;
constexpr std::int64_t kMostTurnsWithoutMark = 8;
constexpr int kMostSearches = 8;
}  // namespace

WheelEncoder::WheelEncoder(const EncoderConfig& config)
    : config_(config),
      tracker_(config.pulses_per_turn),
      grid_{PitchTable(config.pulses_per_turn)},
      history_(static_cast<std::size_t>(std::max(256, kHistoryTurns * config.pulses_per_turn))),
      interpolator_(config.pulses_per_turn),
      pattern_(config.pulses_per_turn),
      marks_(config.pulses_per_turn),
      mark_count_(config.pulses_per_turn) {}

void WheelEncoder::add(NodeTime time, EdgeKind kind) noexcept {
  switch (kind) {
    case EdgeKind::kTooth:
      add_tooth(to_ns(time));
      if (is_own_mark(config_)) add_mark(to_ns(time));
      return;
    case EdgeKind::kZeroMark:
      if (config_.zero_mark && !is_own_mark(config_)) add_mark(to_ns(time));
      return;
    case EdgeKind::kToothBackward:
      tracker_.forget();  // speed and numbers are of a wheel that went forward; a mark counts only then
      return declare_lost();
    case EdgeKind::kLost:
      return declare_lost();
  }
}

/// A turn whose teeth are known to be wrong is one fault, however often it is reported.
void WheelEncoder::declare_lost() noexcept {
  if (grid_.located) {
    ++faulty_turns_;
    turn_faults_ = 1;
  }
  lose();
}

void WheelEncoder::lose() noexcept {
  mark_count_.forget();
  grid_.located = false;
  pending_marks_ = 0;
  forget_teeth();
}

void WheelEncoder::forget_teeth() noexcept {
  history_.clear();
  interpolator_.clear();
  balance_.forget();
  next_search_ = 0;
  searches_ = 0;
}

void WheelEncoder::add_tooth(std::int64_t time_ns) noexcept {
  const auto outcome = tracker_.add(time_ns, grid_);
  const NumberedTooth tooth{time_ns, tracker_.number()};
  switch (outcome) {
    case ToothTracker::Outcome::kStarting:
      return;
    case ToothTracker::Outcome::kStarted:
      for (const NumberedTooth& first : tracker_.starting()) {
        history_.push(first);
        interpolator_.push(first, grid_.position(first.number));
      }
      return;
    case ToothTracker::Outcome::kNumbered:
      count_faults(time_ns, -tracker_.missed());
      history_.push(tooth);
      interpolator_.push(tooth, grid_.position(tooth.number));
      break;
    case ToothTracker::Outcome::kReplaces:
      count_faults(time_ns, 1);
      history_.replace_latest(tooth);
      interpolator_.replace_latest(tooth, grid_.position(tooth.number));
      break;
    case ToothTracker::Outcome::kDropped:
      count_faults(time_ns, 1);
      break;
    case ToothTracker::Outcome::kLost:
      declare_lost();
      return;
  }
  judge_marks();
  if (!grid_.located) find_tooth_again();
  learn_if_turn_complete();
}

/// One that is known only now counts for the turn in which it came, if that is not judged yet.
void WheelEncoder::count_faults(std::int64_t time_ns, std::int64_t surplus) noexcept {
  const auto faults = balance_.add(time_ns, tracker_.number(), surplus, tracker_.jitters());
  if (faults.count == 0) return;
  turn_faults_ += faults.count;
  for (std::size_t i = 0; i < pending_marks_; ++i)
    if (faults.since_ns < pending_[i].time_ns) pending_[i].faults += faults.count;
}

/// After a loss, by the ring's own errors.  Two turns are enough where they are distinctive.
void WheelEncoder::find_tooth_again() noexcept {
  const std::int64_t teeth = config_.pulses_per_turn;
  const bool learned = grid_.table.refinements() >= kLearning_refinements;
  if (!learned && !config_.zero_mark) return count_from_here();
  if (!learned || (config_.zero_mark && !marks_.known())) return;
  if (next_search_ == 0) next_search_ = history_[0].number + 2 * teeth + 2 * PitchPattern::kBeside;
  if (tracker_.number() < next_search_) return;
  next_search_ = tracker_.number() + teeth / 2;
  if (const auto origin = pattern_.find_origin(history_, grid_.table)) return found(*origin);
  if (++searches_ >= kMostSearches && !config_.zero_mark) count_from_here();
}

void WheelEncoder::found(std::int64_t origin) noexcept {
  grid_.origin = origin;
  grid_.located = true;
  learned_turn_ = 0;
  marks_.resume();
  follow_again();
}

void WheelEncoder::count_from_here() noexcept {
  if (history_.empty()) return;
  grid_.table.forget();
  ++count_restarts_;
  found(history_.latest().number);
}

void WheelEncoder::add_mark(std::int64_t time_ns) noexcept {
  if (!tracker_.running()) return;
  if (tracker_.too_long(time_ns)) {  // a place from teeth of long ago is none
    tracker_.forget();
    return declare_lost();
  }
  if (pending_marks_ == pending_.size()) {  // no wheel turns that often in a window: noise
    ++turn_faults_;
    return;
  }
  pending_[pending_marks_++] = {time_ns, turn_faults_};
}

/// Once the teeth after a mark are there, its place among them is known far better than by prediction.
void WheelEncoder::judge_marks() noexcept {
  while (pending_marks_ > 0 && !history_.empty()) {
    const PendingMark mark = pending_[0];
    const auto waited_ns = static_cast<double>(history_.latest().time_ns - mark.time_ns);
    if (waited_ns < interpolator_.half_window_ns(tracker_.pitch_ns())) return;
    std::copy(pending_.begin() + 1, pending_.begin() + static_cast<std::ptrdiff_t>(pending_marks_),
              pending_.begin());
    --pending_marks_;
    std::array<double, 1> position;
    if (interpolator_.positions(mark.time_ns, 0.0, position)) judge(mark, position[0]);
  }
}

void WheelEncoder::judge(const PendingMark& mark, double position) noexcept {
  mark_count_.add(position);
  if (!grid_.located) return locate(mark, position);
  const bool learning = grid_.table.refinements() < kLearning_refinements;
  switch (marks_.judge(position - static_cast<double>(grid_.origin), mark.faults, learning)) {
    case ZeroMarks::Verdict::kFits:
      return end_turn(mark, mark.faults > 0);
    case ZeroMarks::Verdict::kFalse:
      ++turn_faults_;
      return;
    case ZeroMarks::Verdict::kInsists:
      return locate(mark, position);
    case ZeroMarks::Verdict::kSlipped:
      grid_.origin += marks_.slip();
      learned_turn_ = marks_.turn();
      forget_teeth();
      break;
    case ZeroMarks::Verdict::kDoubted:
      break;
  }
  end_turn(mark, true);
}

void WheelEncoder::locate(const PendingMark& mark, double position) noexcept {
  grid_.origin = marks_.locate(position);
  grid_.located = true;
  learned_turn_ = 0;
  follow_again();
  const std::int64_t faulty_turns = faulty_turns_;
  end_turn(mark, mark.faults > 0);
  faulty_turns_ = faulty_turns;  // what came before the first mark was no turn
}

/// The teeth of late, now that the table holds for them.
void WheelEncoder::follow_again() noexcept {
  interpolator_.clear();
  if (history_.empty()) return;
  for (std::size_t i = history_.first_at(history_.latest().time_ns - kFollowAgain_ns); i < history_.size();
       ++i)
    interpolator_.push(history_[i], grid_.position(history_[i].number));
}

/// A turn with faults makes itself and the next one uncertain; an interval of them is kept as long as it may
/// be asked for.
void WheelEncoder::end_turn(const PendingMark& mark, bool faulty) noexcept {
  if (faulty) ++faulty_turns_;
  if (faulty || last_turn_faulty_) doubt_to_ns_ = mark.time_ns;
  last_turn_faulty_ = faulty;
  turn_faults_ -= mark.faults;
  for (std::size_t i = 0; i < pending_marks_; ++i) pending_[i].faults -= mark.faults;
  if (!uncertain() && mark.time_ns > doubt_to_ns_ + kSealing_ns) doubt_from_ns_ = mark.time_ns;
}

void WheelEncoder::learn_if_turn_complete() noexcept {
  if (!grid_.located) return;
  const std::int64_t teeth = config_.pulses_per_turn;
  const std::int64_t turn = (tracker_.number() - grid_.origin) / teeth;
  if (turn <= learned_turn_) return;
  learned_turn_ = turn;
  if (!config_.zero_mark)
    end_turn({history_.latest().time_ns, turn_faults_}, turn_faults_ > 0);
  else if (turn - marks_.turn() > kMostTurnsWithoutMark)
    ++turn_faults_;
  grid_.table.learn(history_, grid_.origin + (turn - PitchTable::kTurns) * teeth, grid_.origin);
  if (grid_.table.refinements() == kLearning_refinements) interpolator_.measure_again();
}

NodeTime WheelEncoder::complete_at(NodeTime last) const noexcept {
  if (!tracker_.running()) return last;
  const double half_ns = interpolator_.half_window_ns(tracker_.pitch_ns());
  return last + NodeClock::duration(static_cast<std::int64_t>(half_ns));
}

bool WheelEncoder::angles(NodeTime first, double step_ns, std::span<double> angle_rad) const noexcept {
  return config_.zero_mark && mark_count_.trusted() && counted_angles(first, step_ns, angle_rad);
}

bool WheelEncoder::counted_angles(NodeTime first, double step_ns,
                                  std::span<double> angle_rad) const noexcept {
  if (!grid_.located || !tracker_.running() || !interpolator_.positions(to_ns(first), step_ns, angle_rad))
    return false;
  const double pitch_rad = 2.0 * std::numbers::pi / config_.pulses_per_turn;
  for (double& angle : angle_rad)
    angle = (angle - static_cast<double>(grid_.origin) - marks_.place()) * pitch_rad + config_.datum_rad;
  return true;
}

double WheelEncoder::sigma_rad() const noexcept {
  const double pitch_rad = 2.0 * std::numbers::pi / config_.pulses_per_turn;
  return std::hypot(interpolator_.sigma_pitches(), marks_.sigma()) * pitch_rad;
}

double WheelEncoder::speed_rad_s(NodeTime now) const noexcept {
  if (!tracker_.running() || history_.empty()) return 0.0;
  if (to_ns(now) - history_.latest().time_ns > ToothTracker::kStandstill_ns) return 0.0;
  return 2.0 * std::numbers::pi / config_.pulses_per_turn / tracker_.pitch_ns() * 1e9;
}

}  // namespace roadbalance
