#pragma once

#include <complex>
#include <string>
#include <vector>

#include "common/bus/compensation.hpp"
#include "common/config/weight_stock.hpp"

namespace roadbalance {

/// Steps that leave least of an unbalance, by weights that can be bought.
///
/// Weights already fitted were on the wheel when the unbalance was found.  Either they stay and others are
/// added beside them, or all places are chosen anew and they are kept, moved or taken off: whichever is
/// expected to leave less, sqrt(|e|^2 + s^2), where every touch of a weight costs (touch_g_m, putting_g_m).
/// Adhesive weights do not hold again once torn off: they are not moved.  An unbalance
/// of 0 leaves everything as it is.  The weights added or chosen anew are those of choose_weights.
///
/// @param deviation_g_m  s, standard deviation of the unbalance: the root of the trace of its covariance; 0:
///                       it is exact
/// @throws std::invalid_argument if the stock has no place, a number is out of its range, the raster does
///         not divide a turn, or s is less than 0
WeightPlan plan_weights(std::complex<double> unbalance_g_m, double deviation_g_m, const WeightStock& stock,
                        const std::vector<WheelWeight>& fitted = {});

/// "clip 15 g at 37° on the outer flange", "stick 15 g at 37° in the inner plane", "move the 20 g clip from
/// 10° to 50° on the outer flange", "remove the 5 g adhesive weight at 90° in the inner plane"; where it is
/// not given how weights hold "add 15 g at 37°"; where the wheel has several radii with "(190 mm)" behind the
/// place.
/// @param radii  at which weights of the wheel are or can be, at least 1
std::string to_string(const WeightStep& step, int radii = 1);

}  // namespace roadbalance
