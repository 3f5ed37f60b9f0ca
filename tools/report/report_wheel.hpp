#pragma once

#include <string>

#include "common/bus/compensation.hpp"
#include "common/bus/results.hpp"
#include "common/bus/weight_check.hpp"

namespace roadbalance {

/// SVG of a wheel as seen from outside the car, its reference point on top: heavy spot, weights, and what the
/// unbalance is as a vector whose full length is `rim_g`.
/// @param before  unbalance before the weights, dashed; nullptr: not known
std::string wheel_svg(const Balance& balance, const Compensation& compensation, double rim_g,
                      const WeightCheck* before = nullptr);

/// It has the unbalance before the weights.
bool tells_before(const WeightCheck& check);

}  // namespace roadbalance
