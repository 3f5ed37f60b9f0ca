#pragma once

#include <string>

#include "common/bus/compensation.hpp"
#include "common/bus/results.hpp"

namespace roadbalance {

/// SVG of a wheel as seen from outside the car, its zero mark on top: heavy spot, weights, and what the
/// unbalance is as a vector whose full length is `rim_g`.
std::string wheel_svg(const Balance& balance, const Compensation& compensation, double rim_g);

}  // namespace roadbalance
