#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "common/angle/local_fit.hpp"

namespace roadbalance {

/// Numbered teeth -> position of the wheel at any instant: a local cubic through the teeth around it.
///
/// How far it reaches is measured while driving, as the best compromise between the teeth's noise, which a
/// long window averages out, and torsional motion, which it smooths away (O. Lepski's comparison of nested
/// estimates): where the position by a window differs from that by the shortest more than their noise
/// explains, the rest is its bias.  The shortest passes 13 Hz to 0.5 %; the longest waits 60 ms.  Where a
/// wheel has many teeth, a few in a row are one point.  Never allocates after construction.
class AngleInterpolator {
 public:
  explicit AngleInterpolator(int teeth);

  /// @param position  of the tooth in pitches, its error included
  void push(const NumberedTooth& tooth, double position) noexcept;
  /// The latest was no tooth; this one is.
  void replace_latest(const NumberedTooth& tooth, double position) noexcept;
  void clear() noexcept;
  /// The teeth are known much better now: measurements of them no longer hold.
  void measure_again() noexcept;

  /// Positions at first + i * step_ns.  False if the teeth do not determine all of them.
  [[nodiscard]] bool positions(std::int64_t first_ns, double step_ns,
                               std::span<double> position) const noexcept;

  /// How long after an instant teeth count for it.
  double half_window_ns(double pitch_ns) const noexcept;
  /// Standard deviation of a position, noise and smoothing together; pitches.  Infinite before it is
  /// measured.
  double sigma_pitches() const noexcept;

 private:
  static constexpr std::array<double, 5> kHalfWindow_ns{12.5e6, 18e6, 27e6, 40e6, 60e6};
  struct Trial {
    double difference_square = 0.0;  ///< mean, from the shortest window; pitches^2
    double variance = 0.0;           ///< of the middle of its window, where that of a tooth is 1
  };
  void compare_windows() noexcept;
  void choose() noexcept;
  double half_window_ns(double pitch_ns, double piece_ns) const noexcept;
  double bias_square(std::size_t k) const noexcept;
  bool fit(std::int64_t from_ns, std::int64_t to_ns, LocalFit& local) const noexcept;

  const int group_;  ///< teeth in a point
  const double pitch_deg_;
  WheelPath path_;
  WheelPoint before_;  ///< the latest point without its latest tooth
  std::int64_t latest_group_ = std::numeric_limits<std::int64_t>::min();

  std::array<Trial, kHalfWindow_ns.size()> trial_{};
  double noise_ = 0.0;  ///< variance of a tooth, pitches^2
  int comparisons_ = 0;
  std::int64_t next_comparison_ns_ = std::numeric_limits<std::int64_t>::min();
  std::size_t chosen_ = 0;
};

}  // namespace roadbalance
