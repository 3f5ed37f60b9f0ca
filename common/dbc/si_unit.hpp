#pragma once

#include <optional>
#include <string_view>

namespace roadbalance {

/// How a number in some unit becomes one in SI units.
struct SiUnit {
  double factor = 1.0;
  const char* name = "";  ///< of the SI unit, e.g. "m/s"; "" for a pure number
};

/// For a unit as DBC files write it: km/h, kph, mph, m/s, deg, rad, deg/s, rad/s, rpm, 1/min, none.
/// @return nothing if it is another
std::optional<SiUnit> si_unit(std::string_view unit);

}  // namespace roadbalance
