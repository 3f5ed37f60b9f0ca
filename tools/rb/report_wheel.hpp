#pragma once

#include <string>

#include "common/bus/compensation.hpp"
#include "common/bus/results.hpp"
#include "common/bus/verification.hpp"

namespace roadbalance {

/// SVG of a wheel as seen from outside the car, its reference point on top: heavy spot, weights, and what the
/// unbalance is as a vector whose full length is `rim_g`.
/// @param before  what it was before the weights, dashed; nullptr: nobody knows
std::string wheel_svg(const Balance& balance, const Compensation& compensation, double rim_g,
                      const WheelVerification* before = nullptr);

/// It tells what was before the weights.
bool tells_before(const WheelVerification& verification);

}  // namespace roadbalance
