#pragma once

#include <complex>
#include <vector>

#include "common/config/weight_stock.hpp"

namespace roadbalance {

/// Expected rms of what is left, sqrt(|e|^2 + s^2), g m.
double expected_g_m(std::complex<double> residual_g_m, double deviation_g_m);

/// Cost of a touch of a weight, g m: a tenth of a step's moment or of the standard deviation, whichever is
/// more.  So nobody is sent to clip a second weight for less than the uncertainty.
double touch_g_m(const WeightStock& stock, double deviation_g_m);

/// Cost of putting a weight where it is: a touch, and half of one more on any place but the first of the
/// stock, which is the one that is wanted.  So no weight goes elsewhere for an unnoticeable gain.
double putting_g_m(const WheelWeight& weight, const WeightStock& stock, double deviation_g_m);

/// The weights, at most stock.most, of least cost
///
///     sqrt(|x - sum of moments|^2 + s^2) + putting_g_m of each + a hundredth of the weights' moments,
///
/// so that of those that leave as much the lightest are chosen, and of those the ones on the place listed
/// first.  No weight lies on another.
///
/// One weight, and two on a raster: the least of all masses, places and angles.  Two at free angles close the
/// triangle, the one with moment a at
///
///     arg x +- acos((|x|^2 + a^2 - b^2) / (2 |x| a));
///
/// one that would lie on another goes to either side of it and the other is aimed anew.
///
/// @param stock          sound (plan_weights)
/// @param wanted_g_m     x
/// @param deviation_g_m  s, standard deviation of x, the root of the trace of its covariance; 0: exact
/// @param staying        weights that stay where they are
std::vector<WheelWeight> choose_weights(const WeightStock& stock, std::complex<double> wanted_g_m,
                                        double deviation_g_m, const std::vector<WheelWeight>& staying);

/// True if the weights need the same part of a place.
bool lies_on(const WheelWeight& a, const WheelWeight& b, const WeightStock& stock);

/// 0 .. 2 pi
double wrap_turn(double angle_rad);

}  // namespace roadbalance
