#pragma once

#include <numbers>

namespace roadbalance {

inline double degrees(double radians) {
  return radians * 180.0 / std::numbers::pi;
}

}  // namespace roadbalance
