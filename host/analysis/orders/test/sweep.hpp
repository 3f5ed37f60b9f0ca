#pragma once

#include <cmath>
#include <numbers>

namespace roadbalance::test {

/// A wheel whose rotation rises evenly from `from_hz` by `rise_hz_s`, in turns.
struct Sweep {
  double from_hz;
  double rise_hz_s;
  double first_turns = 0.3;  ///< where it stands at time 0

  double turns(double time_s) const { return first_turns + time_s * (from_hz + 0.5 * rise_hz_s * time_s); }
  double rotation_hz(double time_s) const { return from_hz + rise_hz_s * time_s; }
  /// The inverse of turns().
  double time_s(double turned) const {
    const double c = turned - first_turns;
    return 2.0 * c / (from_hz + std::sqrt(from_hz * from_hz + 2.0 * rise_hz_s * c));
  }
};

/// A cos(h alpha + phase).
struct OrderSignal {
  double order, amplitude, phase_rad = 0.0;

  double at(double turns) const {
    return amplitude * std::cos(2.0 * std::numbers::pi * order * turns + phase_rad);
  }
};

}  // namespace roadbalance::test
