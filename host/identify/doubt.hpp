#pragma once

#include "common/bus/results.hpp"

namespace roadbalance {

/// Adds to the uncertainty of an unbalance, ellipse and sigmas alike, what its own estimate cannot know.
/// @param along   variance of its length, as a share of it squared
/// @param across  variance of its angle, rad^2
void add_doubt(Balance& balance, double along, double across);

}  // namespace roadbalance
