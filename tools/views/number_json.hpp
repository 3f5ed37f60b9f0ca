#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

namespace roadbalance {

/// JSON has neither infinity nor NaN: null.
inline nlohmann::ordered_json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace roadbalance
