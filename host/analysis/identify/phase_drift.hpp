#pragma once

#include <array>
#include <bitset>
#include <numbers>
#include <optional>

#include <Eigen/Core>

#include "host/analysis/identify/signals.hpp"

namespace roadbalance {

/// How far each two wheels have turned against one another over the stretches of a drive.
///
/// The angle between two references is noted to the degree, modulo a turn: zero marks give it anew after
/// every hole, so stretches need not join.
class PhaseDrift {
 public:
  /// Takes a stretch, column a sample.
  /// @param has_angle  which wheels' references are there all through
  void add(const Eigen::Ref<const SignalMatrix>& signals, const std::array<bool, kWheels>& has_angle);

  /// Adds observations from elsewhere of the same wheels and zero marks.
  void add(const PhaseDrift& other);

  /// The smallest arc that holds all angles between the two wheels, to a degree; nothing: never seen
  /// together.
  std::optional<double> drift_rad(int a, int b) const;

  static constexpr std::size_t kCells = 360;
  /// By the lower and the higher wheel.
  std::array<std::array<std::bitset<kCells>, kWheels>, kWheels> seen;
};

/// Wheels that turned against one another by less than this turn in step.
inline constexpr double kLeastDrift_rad = std::numbers::pi / 6.0;

/// The wheel that each wheel turned in step with over the drive; nothing: with none.
std::array<std::optional<int>, kWheels> in_step(const PhaseDrift& drift);

}  // namespace roadbalance
