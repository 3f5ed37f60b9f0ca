#pragma once

#include <optional>
#include <string_view>

#include "common/vehicle/gravity.hpp"

namespace roadbalance {

/// Units that samples may come in.
inline constexpr const char* kKnownUnits = "m/s^2, m/s2, g, m";

/// Of a number whose SI value is infinite.
inline constexpr const char* kTooLarge = "is too large; allowed: what is a finite number in SI units";

/// What a number in this unit is multiplied by; nothing: the unit is not known.
inline std::optional<double> factor_of_unit(std::string_view unit) {
  if (unit == "m/s^2" || unit == "m/s2" || unit == "m") return 1.0;
  if (unit == "g") return kStandardGravity_m_s2;
  return std::nullopt;
}

}  // namespace roadbalance
