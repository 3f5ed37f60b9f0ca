#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "common/encoder/least_squares.hpp"
#include "common/encoder/tooth_history.hpp"

namespace roadbalance {

/// Where the wheel was at an instant: the mean of a few teeth in a row, or one tooth.
struct WheelPoint {
  std::int64_t time_ns = 0;
  double position = 0.0;  ///< pitches
  double weight = 0.0;    ///< how many teeth
};
using WheelPath = History<WheelPoint>;

/// Of the teeth of `point` and one more; of a point without teeth, that tooth.
inline WheelPoint with_tooth(const WheelPoint& point, const NumberedTooth& tooth, double position) {
  if (point.weight == 0.0) return {tooth.time_ns, position, 1.0};
  const double weight = point.weight + 1.0;
  return {point.time_ns + std::llround(static_cast<double>(tooth.time_ns - point.time_ns) / weight),
          point.position + (position - point.position) / weight, weight};
}
/// How many teeth of a dense ring make a point: at least 128 points a turn tell any motion.
inline int teeth_in_a_point(int teeth) {
  return std::max(1, teeth / 128);
}

/// Cubic of position in time through a stretch of points; those far off were no teeth and do not count.
class LocalFit {
 public:
  static constexpr std::size_t kLeastPoints = 6;
  static constexpr double kOutlier = 4.5;  ///< times the noise of a point

  /// Points [begin, end).
  /// @param noise  variance of the position of one tooth, pitches^2; 0 if not known
  [[nodiscard]] bool fit(const WheelPath& path, std::size_t begin, std::size_t end, double noise) noexcept {
    if (end - begin < kLeastPoints) return false;
    first_ns_ = path[begin].time_ns;
    half_ns_ = 0.5 * static_cast<double>(path[end - 1].time_ns - first_ns_);
    origin_ = path[begin].position;
    cubic_ = {};
    for (std::size_t i = begin; i < end; ++i)
      cubic_.add(scaled(path[i].time_ns), path[i].position - origin_, path[i].weight);
    if (!cubic_.solve()) return false;
    judge(path, begin, end, noise);
    return true;
  }

  double position(double after_first_ns) const noexcept {
    return origin_ + cubic_.value(after_first_ns / half_ns_ - 1.0);
  }
  /// Variance of position() where that of a tooth is 1.
  double variance(double after_first_ns) const noexcept {
    return cubic_.variance(after_first_ns / half_ns_ - 1.0);
  }
  std::int64_t first_ns() const noexcept { return first_ns_; }
  /// Variance of a tooth as this fit sees it, pitches^2.
  double noise() const noexcept { return noise_; }

 private:
  double scaled(std::int64_t time_ns) const noexcept {
    return static_cast<double>(time_ns - first_ns_) / half_ns_ - 1.0;
  }
  double residual(const WheelPoint& point) const noexcept {
    return point.position - origin_ - cubic_.value(scaled(point.time_ns));
  }

  void judge(const WheelPath& path, std::size_t begin, std::size_t end, double noise) noexcept {
    const auto points = static_cast<double>(end - begin);
    const double freedom = points - LeastSquares<3>::kTerms;
    double square = 0.0, largest = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const double r = residual(path[i]);
      const double scatter = r * r * path[i].weight;
      square += scatter;
      largest = std::max(largest, scatter);
    }
    noise_ = square / freedom;
    const double limit = kOutlier * kOutlier * (noise > 0.0 ? std::min(noise, noise_) : 0.6 * noise_);
    if (largest <= limit) return;
    LeastSquares<3> good;
    double kept = 0.0, good_square = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const double r = residual(path[i]);
      if (r * r * path[i].weight > limit) continue;
      good.add(scaled(path[i].time_ns), path[i].position - origin_, path[i].weight);
      good_square += r * r * path[i].weight;
      kept += 1.0;
    }
    // More than a few are no outliers: the noise has grown.
    if (kept < 0.8 * points || kept < static_cast<double>(kLeastPoints) || !good.solve()) return;
    cubic_ = good;
    noise_ = good_square / std::max(1.0, kept - LeastSquares<3>::kTerms);
  }

  LeastSquares<3> cubic_;
  std::int64_t first_ns_ = 0;
  double half_ns_ = 1.0, origin_ = 0.0, noise_ = 0.0;
};

}  // namespace roadbalance
