#include "common/angle/pitch_pattern.hpp"

#include <algorithm>
#include <limits>

#include "common/angle/least_squares.hpp"

namespace roadbalance {

namespace {
constexpr double kLeastLogRatio = 20.0;
constexpr double kWorstFit = 2.5;  // of the mean square; 1 is expected

/// Weight of the tooth `j` beside in a cubic fit to 2 m + 1 equidistant ones, at the middle (Savitzky, Golay,
/// Anal. Chem. 36, 1964).
double cubic_weight(int j) {
  constexpr double m = PitchPattern::kBeside;
  return 3.0 * (3.0 * m * m + 3.0 * m - 1.0 - 5.0 * j * j) /
         ((2.0 * m + 3.0) * (2.0 * m + 1.0) * (2.0 * m - 1.0));
}
}  // namespace

PitchPattern::PitchPattern(int teeth)
    : teeth_(static_cast<std::size_t>(teeth)), seen_(teeth_), weight_(teeth_), expected_(teeth_) {}

bool PitchPattern::observe(const ToothHistory& history) noexcept {
  std::ranges::fill(seen_, 0.0);
  std::ranges::fill(weight_, 0.0);
  noise_ = 0.0;
  double fits = 0.0;
  const std::size_t most = kMostTurns * teeth_ + 2 * kBeside;
  for (std::size_t i = history.size() - std::min(history.size(), most) + kBeside;
       i + kBeside < history.size(); ++i) {
    const NumberedTooth &first = history[i - kBeside], &middle = history[i], &last = history[i + kBeside];
    if (last.number - first.number != 2 * kBeside) continue;  // a tooth is missing
    const double half_ns = 0.5 * static_cast<double>(last.time_ns - first.time_ns);
    const auto u = [&](std::size_t k) {
      return static_cast<double>(history[k].time_ns - first.time_ns) / half_ns - 1.0;
    };
    LeastSquares<3> motion;
    for (std::size_t k = i - kBeside; k <= i + kBeside; ++k)
      motion.add(u(k), static_cast<double>(history[k].number - middle.number));
    if (!motion.solve()) continue;
    const auto place = static_cast<std::size_t>(middle.number % static_cast<std::int64_t>(teeth_));
    const double off = motion.value(u(i)), before = seen_[place];
    weight_[place] += 1.0;
    seen_[place] += (off - before) / weight_[place];
    if (weight_[place] > 1.0) {  // its scatter from turn to turn is noise
      noise_ += (off - before) * (off - seen_[place]);
      fits += 1.0;
    }
  }
  const auto seen = std::ranges::count_if(weight_, [](double weight) { return weight > 0.0; });
  if (10 * static_cast<std::size_t>(seen) < 9 * teeth_ || fits < 0.5 * static_cast<double>(teeth_))
    return false;
  noise_ /= fits;
  return noise_ > 0.0;
}

/// Half the sum of squares by noise, if the tooth of number n is the table's tooth n + shift.
double PitchPattern::misfit(std::size_t shift) const noexcept {
  double sum = 0.0;
  std::size_t k = shift;
  for (std::size_t n = 0; n < teeth_; ++n) {
    const double difference = seen_[n] - expected_[k];
    sum += weight_[n] * difference * difference;
    if (++k == teeth_) k = 0;
  }
  return 0.5 * sum / noise_;
}

std::optional<std::int64_t> PitchPattern::find_origin(const ToothHistory& history,
                                                      const PitchTable& table) noexcept {
  if (teeth_ > kMostTeeth || history.empty() || !observe(history)) return std::nullopt;
  for (std::size_t n = 0; n < teeth_; ++n) {
    const auto tooth = static_cast<std::int64_t>(n);
    expected_[n] = table.error_pitches(tooth);
    for (int j = -kBeside; j <= kBeside; ++j)
      expected_[n] -= cubic_weight(j) * table.error_pitches(tooth + j);
  }
  double best = std::numeric_limits<double>::infinity(), second = best, weight = 0.0;
  std::size_t shift = 0;
  for (std::size_t s = 0; s < teeth_; ++s) {
    const double value = misfit(s);
    if (value < best) {
      second = best;
      best = value;
      shift = s;
    } else {
      second = std::min(second, value);
    }
  }
  for (const double w : weight_) weight += w > 0.0 ? 1.0 : 0.0;
  // For means over some turns the misfit is half a square for each tooth.
  if (second - best < kLeastLogRatio || best > kWorstFit * 0.5 * weight) return std::nullopt;
  const auto teeth = static_cast<std::int64_t>(teeth_);
  const std::int64_t latest = history.latest().number;
  return latest - (latest + static_cast<std::int64_t>(shift)) % teeth;
}

}  // namespace roadbalance
