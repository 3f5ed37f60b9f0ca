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
/// added beside them, or all places are chosen anew and they are kept, moved or taken off: whichever leaves
/// less, where every touch of a weight counts as a tenth of a step's moment.  An unbalance of 0 leaves
/// everything as it is.
///
/// At most stock.most weights are added or chosen anew; of those that leave as much the lightest.  One weight:
/// the nearest multiple over the radii.  Two at free angles: with |x| between the difference and the sum of
/// their moments a, b they close the triangle exactly,
///     angle = arg x +- acos((|x|^2 + a^2 - b^2) / (2 |x| a))   of the one with moment a.
/// On a raster all masses and places of the first are tried, with the nearest of the second.  A weight that
/// would lie on one that stays goes to either side of it.
///
/// @throws std::invalid_argument if the stock has no radius, a number is out of its range, or the raster does
///         not divide a turn
WeightPlan plan_weights(std::complex<double> unbalance_g_m, const WeightStock& stock,
                        const std::vector<WheelWeight>& fitted = {});

/// "add 15 g at 37°", "move 20 g from 10° to 50°", "remove 5 g at 90°"; where the wheel has several radii
/// "add 15 g at 37° on 190 mm".
/// @param radii  of its places, at least 1
std::string to_string(const WeightStep& step, int radii = 1);

}  // namespace roadbalance
