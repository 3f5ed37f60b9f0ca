#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "common/angle/least_squares.hpp"
#include "common/angle/tooth_history.hpp"

namespace roadbalance {

/// Where the wheel was at an instant: the mean of a few teeth in a row, or one tooth.
struct WheelPoint {
  std::int64_t time_ns = 0;
  double position = 0.0;  ///< pitches
  double weight = 0.0;    ///< how many teeth
};
using WheelPath = History<WheelPoint>;

/// The teeth of `point` and one more; for a point without teeth, that tooth.
inline WheelPoint with_tooth(const WheelPoint& point, const NumberedTooth& tooth, double position) {
  if (point.weight == 0.0) return {tooth.time_ns, position, 1.0};
  const double weight = point.weight + 1.0;
  return {point.time_ns + std::llround(static_cast<double>(tooth.time_ns - point.time_ns) / weight),
          point.position + (position - point.position) / weight, weight};
}
/// How many teeth of a dense wheel make a point: at least 128 points a turn resolve any motion.
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
    per_half_ns_ = 2.0 / static_cast<double>(path[end - 1].time_ns - first_ns_);
    origin_ = path[begin].position;
    Cubic cubic;  // here, where its sums stay in registers
    for (std::size_t i = begin; i < end; i += 2) {
      const Two two = two_points(path, i, end);
      cubic.add(two.u, two.y, two.weight);
    }
    if (!cubic.solve()) return false;
    cubic_ = cubic;
    judge(path, begin, end, noise);
    return true;
  }

  double position(double after_first_ns) const noexcept {
    return origin_ + cubic_.value(after_first_ns * per_half_ns_ - 1.0);
  }
  /// Variance of position() where that of a tooth is 1.
  double variance(double after_first_ns) const noexcept {
    return cubic_.variance(after_first_ns * per_half_ns_ - 1.0);
  }
  std::int64_t first_ns() const noexcept { return first_ns_; }
  /// Variance of a tooth as this fit sees it, pitches^2.
  double noise() const noexcept { return noise_; }

 private:
  using Vector = Lanes<2>::Vector;
  using Cubic = LeastSquares<3, Vector>;
  struct Two {
    Vector u, y, weight;
  };

  double scaled(std::int64_t time_ns) const noexcept {
    return static_cast<double>(time_ns - first_ns_) * per_half_ns_ - 1.0;
  }
  /// Point i and the next one, which has no weight if `end` is before it.
  Two two_points(const WheelPath& path, std::size_t i, std::size_t end) const noexcept {
    const bool alone = i + 1 == end;
    const WheelPoint &a = path[i], &b = alone ? a : path[i + 1];
    const Vector u{scaled(a.time_ns), scaled(b.time_ns)}, y{a.position - origin_, b.position - origin_},
        weight{a.weight, alone ? 0.0 : b.weight};
    return {u, y, weight};
  }
  /// Squares of what the cubic leaves, times the weights.
  Vector scatter(const Two& two) const noexcept {
    const Vector residual = two.y - cubic_.value(two.u);
    return residual * residual * two.weight;
  }

  void judge(const WheelPath& path, std::size_t begin, std::size_t end, double noise) noexcept {
    const auto points = static_cast<double>(end - begin);
    const double freedom = points - Cubic::kTerms;
    Vector square{};
    double largest = 0.0;
    for (std::size_t i = begin; i < end; i += 2) {
      const Vector scattered = scatter(two_points(path, i, end));
      square += scattered;
      largest = std::max(largest, std::max(scattered[0], scattered[1]));
    }
    noise_ = (square[0] + square[1]) / freedom;
    const double limit = kOutlier * kOutlier * (noise > 0.0 ? std::min(noise, noise_) : 0.6 * noise_);
    if (largest <= limit) return;
    Cubic good;
    double kept = points, good_square = 0.0;
    for (std::size_t i = begin; i < end; i += 2) {
      Two two = two_points(path, i, end);
      const Vector scattered = scatter(two);
      for (const int k : {0, 1}) {
        if (scattered[k] <= limit) {
          good_square += scattered[k];
        } else {
          two.weight[k] = 0.0;
          kept -= 1.0;
        }
      }
      good.add(two.u, two.y, two.weight);
    }
    // More than a few are no outliers: the noise has grown.
    if (kept < 0.8 * points || kept < static_cast<double>(kLeastPoints) || !good.solve()) return;
    cubic_ = good;
    noise_ = good_square / std::max(1.0, kept - Cubic::kTerms);
  }

  Cubic cubic_;
  std::int64_t first_ns_ = 0;
  double per_half_ns_ = 1.0, origin_ = 0.0, noise_ = 0.0;
};

}  // namespace roadbalance
