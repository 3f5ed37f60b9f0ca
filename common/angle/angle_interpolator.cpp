#include "common/angle/angle_interpolator.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {

namespace {
constexpr int kInterpolatedTurns = 32;  // 0.5 s at 60 turns a second: more than a block ever waits
constexpr double kLeastPiece_ns = 5e6;  // instants that share one fit
constexpr double kPiece = 0.2;          // of the window: in the middle the cubic is best
constexpr double kLeastHalfWindow_points = 3.0;
constexpr std::int64_t kComparison_ns = 50'000'000;
constexpr int kMemory_comparisons = 400;  // 20 s
constexpr double kChance = 4.0;           // standard deviations; a smoothed torsional motion is far beyond
constexpr int kFirstChoice_comparisons = 20;
constexpr double kGoodEnough_deg = 0.0015;  // of two windows that are as good as this the shorter waits less

std::size_t history_points(int teeth) {
  return static_cast<std::size_t>(std::max(256, kInterpolatedTurns * (teeth / teeth_in_a_point(teeth) + 1)));
}
}  // namespace

AngleInterpolator::AngleInterpolator(int teeth)
    : group_(teeth_in_a_point(teeth)), pitch_deg_(360.0 / teeth), path_(history_points(teeth)) {}

void AngleInterpolator::clear() noexcept {
  path_.clear();
  before_ = {};
  latest_group_ = std::numeric_limits<std::int64_t>::min();
  next_comparison_ns_ = std::numeric_limits<std::int64_t>::min();
}

void AngleInterpolator::push(const NumberedTooth& tooth, double position) noexcept {
  const std::int64_t group = group_ == 1 ? tooth.number : tooth.number / group_;
  if (group == latest_group_ && !path_.empty()) {
    before_ = path_.latest();
    path_.replace_latest(with_tooth(before_, tooth, position));
    return;
  }
  latest_group_ = group;
  before_ = {};
  path_.push(with_tooth(before_, tooth, position));
  if (next_comparison_ns_ == std::numeric_limits<std::int64_t>::min())
    next_comparison_ns_ = tooth.time_ns + kComparison_ns;
  if (static_cast<double>(tooth.time_ns - next_comparison_ns_) > kHalfWindow_ns.back()) {
    compare_windows();
    next_comparison_ns_ = std::max(next_comparison_ns_ + kComparison_ns,
                                   tooth.time_ns - static_cast<std::int64_t>(kHalfWindow_ns.back()));
  }
}

void AngleInterpolator::replace_latest(const NumberedTooth& tooth, double position) noexcept {
  path_.replace_latest(with_tooth(before_, tooth, position));
}

bool AngleInterpolator::fit(std::int64_t from_ns, std::int64_t to_ns, LocalFit& local) const noexcept {
  return local.fit(path_, path_.first_at(from_ns), path_.first_at(to_ns + 1), noise_);
}

void AngleInterpolator::compare_windows() noexcept {
  const std::int64_t middle_ns = next_comparison_ns_;
  std::array<double, kHalfWindow_ns.size()> position;
  std::array<double, kHalfWindow_ns.size()> variance;
  double noise = 0.0;
  for (std::size_t k = 0; k < kHalfWindow_ns.size(); ++k) {
    const auto half_ns = static_cast<std::int64_t>(kHalfWindow_ns[k]);
    if (path_[0].time_ns > middle_ns - half_ns) return;
    LocalFit local;
    if (!fit(middle_ns - half_ns, middle_ns + half_ns, local)) return;
    const auto after_first_ns = static_cast<double>(middle_ns - local.first_ns());
    position[k] = local.position(after_first_ns) - static_cast<double>(latest_group_ * group_);
    variance[k] = local.variance(after_first_ns);
    if (k == 0) noise = local.noise();
  }
  comparisons_ = std::min(comparisons_ + 1, kMemory_comparisons);
  const double gain = 1.0 / comparisons_;
  noise_ += gain * (noise - noise_);
  for (std::size_t k = 0; k < kHalfWindow_ns.size(); ++k) {
    const double difference = position[k] - position[0];
    trial_[k].difference_square += gain * (difference * difference - trial_[k].difference_square);
    trial_[k].variance += gain * (variance[k] - trial_[k].variance);
  }
  if (comparisons_ >= kFirstChoice_comparisons) choose();
}

void AngleInterpolator::choose() noexcept {
  const auto risk = [&](std::size_t k) { return noise_ * trial_[k].variance + bias_square(k); };
  double least = risk(0);
  for (std::size_t k = 1; k < trial_.size(); ++k) least = std::min(least, risk(k));
  const double good_enough = kGoodEnough_deg / pitch_deg_;
  least = std::max(1.02 * least, good_enough * good_enough);
  chosen_ = 0;
  while (risk(chosen_) > least) ++chosen_;
}

/// The part that noise cannot explain.  The difference of nested least-squares fits has the difference of
/// their variances, and the mean square of so many chances to be larger.
double AngleInterpolator::bias_square(std::size_t k) const noexcept {
  const double by_noise = noise_ * (trial_[0].variance - trial_[k].variance);
  const double by_chance = kChance * by_noise * std::sqrt(2.0 / comparisons_);
  return std::max(0.0, trial_[k].difference_square - by_noise - by_chance);
}

double AngleInterpolator::sigma_pitches() const noexcept {
  if (comparisons_ == 0) return std::numeric_limits<double>::infinity();
  return std::sqrt(noise_ * trial_[chosen_].variance + bias_square(chosen_));
}

void AngleInterpolator::measure_again() noexcept {
  comparisons_ = 0;
}

double AngleInterpolator::half_window_ns(double pitch_ns) const noexcept {
  return half_window_ns(pitch_ns, kLeastPiece_ns);
}

double AngleInterpolator::half_window_ns(double pitch_ns, double piece_ns) const noexcept {
  return std::max(kHalfWindow_ns[chosen_] - 0.5 * std::max(piece_ns, kLeastPiece_ns),
                  kLeastHalfWindow_points * group_ * pitch_ns);
}

bool AngleInterpolator::positions(std::int64_t first_ns, double step_ns,
                                  std::span<double> position) const noexcept {
  if (path_.size() < LocalFit::kLeastPoints) return false;
  const WheelPoint& latest = path_.latest();
  const WheelPoint& earlier = path_[path_.size() - LocalFit::kLeastPoints];
  const double pitch_ns = static_cast<double>(latest.time_ns - earlier.time_ns) /
                          std::max(1.0, latest.position - earlier.position);
  const double piece_ns = std::max({kLeastPiece_ns, kPiece * 2.0 * kHalfWindow_ns[chosen_],
                                    2.0 * kLeastHalfWindow_points * group_ * pitch_ns});
  const std::size_t piece = step_ns > 0.0
                                ? std::max<std::size_t>(1, static_cast<std::size_t>(piece_ns / step_ns))
                                : position.size();
  const auto after_ns = [&](std::size_t i) { return static_cast<double>(i) * step_ns; };
  for (std::size_t begin = 0; begin < position.size(); begin += piece) {
    const std::size_t end = std::min(begin + piece, position.size());
    const std::int64_t from_ns = first_ns + std::llround(after_ns(begin));
    const std::int64_t to_ns = first_ns + std::llround(after_ns(end - 1));
    const auto half_ns =
        static_cast<std::int64_t>(half_window_ns(pitch_ns, static_cast<double>(to_ns - from_ns)));
    const std::size_t first = path_.first_at(from_ns - half_ns), last = path_.first_at(to_ns + half_ns);
    LocalFit local;
    if (last < first + LocalFit::kLeastPoints || !local.fit(path_, first, last, noise_)) return false;
    const WheelPoint &a = path_[first], &b = path_[last - 1];
    // Outside the teeth only as far as the next one could be.
    const auto reach_ns = static_cast<std::int64_t>(
        1.5 * group_ * static_cast<double>(b.time_ns - a.time_ns) / (b.position - a.position));
    if (from_ns < a.time_ns - reach_ns || to_ns > b.time_ns + reach_ns) return false;
    const auto lead_ns = static_cast<double>(first_ns - a.time_ns);
    for (std::size_t i = begin; i < end; ++i) position[i] = local.position(lead_ns + after_ns(i));
  }
  return true;
}

}  // namespace roadbalance
