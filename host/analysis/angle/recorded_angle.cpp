#include "host/analysis/angle/recorded_angle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace roadbalance {
namespace {

constexpr int kPasses = 4;
constexpr std::int64_t kMostTurnsToLearn = 4000;
constexpr std::int64_t kAngleStretch_ns = 5'000'000'000, kAngleOverlap_ns = 500'000'000;
constexpr std::int64_t kPlaceHalfWindow_ns = 25'000'000;
constexpr std::size_t kNoiseWindow = 24;  // points; a cubic follows any motion over so few

/// Variance of a tooth: the median of what short cubics leave, so that outliers and bumps do not count.
double noise_of(const std::vector<WheelPoint>& points) {
  WheelPath path(kNoiseWindow);
  std::vector<double> noise;
  for (std::size_t i = 0; i < points.size(); ++i) {
    path.push(points[i]);
    if ((i + 1) % kNoiseWindow != 0) continue;
    LocalFit local;
    if (local.fit(path, 0, path.size(), 0.0)) noise.push_back(local.noise());
  }
  if (noise.empty()) return 0.0;
  std::ranges::nth_element(noise, noise.begin() + static_cast<std::ptrdiff_t>(noise.size() / 2));
  return noise[noise.size() / 2];
}

}  // namespace

RecordedAngle::RecordedAngle(const EncoderConfig& config, std::span<const Edge> edges)
    : config_(config), numbered_(number_teeth(config, edges)), table_(config.pulses_per_turn) {
  if (!config.zero_mark) return;  // which tooth is which is not known
  learn_table();
  numbered_ = number_again(config, edges, table_, numbered_);
  table_.forget();
  learn_table();
  learn_place();
}

void RecordedAngle::learn_table() {
  const std::int64_t teeth = config_.pulses_per_turn;
  std::int64_t turns = 0;
  for (const NumberedRun& run : numbered_.runs)
    turns += (run.teeth.back().number - run.teeth.front().number) / teeth;
  const std::int64_t stride = 1 + turns / kMostTurnsToLearn;
  std::vector<ToothHistory> histories;
  for (const NumberedRun& run : numbered_.runs) {
    histories.emplace_back(run.teeth.size());
    for (const NumberedTooth& tooth : run.teeth) histories.back().push(tooth);
  }
  for (int pass = 0; pass < kPasses; ++pass)
    for (const ToothHistory& history : histories)
      for (std::int64_t first = history[0].number;
           first + PitchTable::kTurns * teeth <= history.latest().number; first += stride * teeth)
        table_.learn(history, first, 0);
}

std::vector<WheelPoint> RecordedAngle::points(const NumberedRun& run, std::int64_t from_ns,
                                              std::int64_t to_ns) const {
  const int group = teeth_in_a_point(config_.pulses_per_turn);
  std::vector<WheelPoint> all;
  std::int64_t latest = std::numeric_limits<std::int64_t>::min();
  auto tooth = std::ranges::lower_bound(run.teeth, from_ns, {}, &NumberedTooth::time_ns);
  for (; tooth != run.teeth.end() && tooth->time_ns <= to_ns; ++tooth) {
    const double position = static_cast<double>(tooth->number) + table_.error_pitches(tooth->number);
    const std::int64_t of_group = tooth->number / group;
    if (of_group != latest) all.push_back({});
    latest = of_group;
    all.back() = with_tooth(all.back(), *tooth, position);
  }
  return all;
}

/// The mean over all marks, once each is placed among its teeth.
void RecordedAngle::learn_place() {
  const double teeth = config_.pulses_per_turn;
  double sum = 0.0, square = 0.0, count = 0.0;
  for (const NumberedRun& run : numbered_.runs)
    for (const std::int64_t mark_ns : run.marks_ns) {
      const auto around = points(run, mark_ns - kPlaceHalfWindow_ns, mark_ns + kPlaceHalfWindow_ns);
      if (around.size() < LocalFit::kLeastPoints) continue;
      WheelPath path(around.size());
      for (const WheelPoint& point : around) path.push(point);
      LocalFit local;
      if (!local.fit(path, 0, path.size(), 0.0)) continue;
      const double position =
          std::remainder(local.position(static_cast<double>(mark_ns - local.first_ns())), teeth);
      sum += position;
      square += position * position;
      count += 1.0;
    }
  if (count == 0.0) return;
  place_ = sum / count;
  place_sigma_ = std::sqrt(std::max(0.0, square / count - place_ * place_) / count);
}

bool RecordedAngle::prepare(std::int64_t from_ns, std::int64_t to_ns) {
  if (from_ns_ <= from_ns && to_ns <= to_ns_) return true;
  for (const NumberedRun& run : numbered_.runs) {
    const std::int64_t begin_ns = run.teeth.front().time_ns, end_ns = run.teeth.back().time_ns;
    if (from_ns < begin_ns || to_ns > end_ns) continue;
    const std::int64_t last_ns = std::min(end_ns, std::max(from_ns + kAngleStretch_ns, to_ns));
    const auto stretch = points(run, from_ns - kAngleOverlap_ns, last_ns + kAngleOverlap_ns);
    from_ns_ = to_ns_ = 0;
    if (!smoother_.smooth(stretch, std::max(noise_of(stretch), 1e-12))) return false;
    from_ns_ = std::max(from_ns, stretch.front().time_ns);
    to_ns_ = std::min(last_ns, stretch.back().time_ns);
    return from_ns_ <= from_ns && to_ns <= to_ns_;
  }
  return false;
}

bool RecordedAngle::angles(NodeTime first, double step_ns, std::span<double> angle_rad) {
  return config_.zero_mark && look_up(first, step_ns, angle_rad);
}

bool RecordedAngle::turned(NodeTime first, double step_ns, std::span<double> angle_rad) {
  return !config_.zero_mark && look_up(first, step_ns, angle_rad);
}

bool RecordedAngle::look_up(NodeTime first, double step_ns, std::span<double> angle_rad) {
  const auto instant = [&](std::size_t i) {
    return to_ns(first) + std::llround(static_cast<double>(i) * step_ns);
  };
  if (angle_rad.empty() || !prepare(instant(0), instant(angle_rad.size() - 1))) return false;
  const double pitch_rad = 2.0 * std::numbers::pi / config_.pulses_per_turn;
  for (std::size_t i = 0; i < angle_rad.size(); ++i)
    angle_rad[i] = (smoother_.position(instant(i)) - place_) * pitch_rad + config_.datum_rad;
  sigma_ = std::hypot(smoother_.sigma(instant(angle_rad.size() / 2)), place_sigma_) * pitch_rad;
  return true;
}

bool RecordedAngle::uncertain(NodeTime first, NodeTime last) const {
  const auto turn =
      std::ranges::lower_bound(numbered_.faulty_turns, to_ns(first), {}, &NumberedTeeth::Turn::to_ns);
  return turn != numbered_.faulty_turns.end() && turn->from_ns <= to_ns(last);
}

double RecordedAngle::common_sigma_rad() const {
  return place_sigma_ * 2.0 * std::numbers::pi / config_.pulses_per_turn;
}

double RecordedAngle::sigma_rad() const {
  return sigma_;
}

}  // namespace roadbalance
