#pragma once

#include <complex>
#include <string>
#include <vector>

namespace roadbalance {

/// What weights there are to clip or stick on, and where.
struct WeightStock {
  double step_g = 5.0;       ///< masses are multiples of this; 7.0874 g is a quarter of an ounce
  double heaviest_g = 60.0;  ///< in one place
  int most = 2;              ///< weights on a wheel, 1 or 2
  /// Radii of the places: inner and outer rim flange, or where adhesive weights are stuck.
  std::vector<double> radius_m;
  double raster_rad = 0.0;         ///< angle between places, counted from the zero mark; 0: anywhere
  double length_m_per_g = 2.5e-3;  ///< of a weight along the rim: two do not lie on one another
};

/// A weight on a wheel; angle from the zero mark in the direction of rotation.
struct WheelWeight {
  double mass_g = 0.0;
  double angle_rad = 0.0;
  double radius_m = 0.0;

  /// Mass times radius at its angle, g m.
  std::complex<double> moment_g_m() const { return std::polar(mass_g * radius_m, angle_rad); }
};

enum class WeightAction { kKeep, kMove, kRemove, kAdd };

struct WeightStep {
  WeightAction action = WeightAction::kAdd;
  WheelWeight weight;  ///< where it shall be; of one to remove where it is
  WheelWeight from;    ///< of one to move: where it is
};

struct WeightPlan {
  std::vector<WeightStep> step;
  /// What the steps add to what was on the wheel when its unbalance was found, g m.
  std::complex<double> applied_g_m = 0.0;

  /// What is left of an unbalance, g m: of the estimate the prediction, of the truth what came of it.
  std::complex<double> residual_g_m(std::complex<double> unbalance_g_m) const {
    return unbalance_g_m + applied_g_m;
  }
};

/// Steps that leave least of an unbalance, by weights that can be bought.
///
/// Weights already fitted were on the wheel when the unbalance was found.  Either they stay and others are
/// added, or all places are chosen anew and they are kept, moved or taken off: whichever leaves less, where
/// every touch of a weight counts as a tenth of a step's moment.  An unbalance of 0 leaves everything as it
/// is.
///
/// One weight: the nearest multiple over the radii.  Two at free angles: with |x| between the difference and
/// the sum of their moments a, b they close the triangle exactly,
///     angle = arg x +- acos((|x|^2 + a^2 - b^2) / (2 |x| a))   of the one with moment a.
/// On a raster all masses and places of the first are tried, with the nearest of the second.
///
/// @throws std::invalid_argument if the stock has no radius, or a number is out of its range
WeightPlan plan_weights(std::complex<double> unbalance_g_m, const WeightStock& stock,
                        const std::vector<WheelWeight>& fitted = {});

/// "add 15 g at 37°", "move 20 g from 10° to 50°", "remove 5 g at 90°".
std::string to_string(const WeightStep& step);

}  // namespace roadbalance
