#pragma once

#include <algorithm>
#include <cmath>

namespace roadbalance {

/// Whether two values of a vehicle.toml are one: a text of fewer digits than a double, or a product of such,
/// differs by far less than 1e-9, and no calibration is known so well.
inline bool is_same_number(double a, double b) {
  return std::abs(a - b) <= 1e-9 * std::max(std::abs(a), std::abs(b));
}

}  // namespace roadbalance
