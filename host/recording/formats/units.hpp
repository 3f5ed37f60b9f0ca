#pragma once

#include <optional>
#include <string_view>

namespace roadbalance {

enum class Quantity { kAcceleration, kLength, kVoltage };

struct Unit {
  Quantity quantity;
  double factor;  ///< to m/s^2, m or V
};

/// Units that samples may come in.
inline constexpr const char* kAccelerationUnits = "m/s^2, mm/s^2, cm/s^2, in/s^2, ft/s^2, g, mg";
inline constexpr const char* kLengthUnits = "m, mm, cm, in, ft";

/// The error for a number whose SI value is infinite.
inline constexpr const char* kTooLarge = "is too large; allowed: what is a finite number in SI units";

/// A unit by its name, in capitals or not, with blanks or not: "m/s^2", "m/s2", "m/s**2", "m/s²" (UTF-8 and
/// ISO 8859-1), "m/sec^2" are one.  Nothing: the name is unknown, or is that of another quantity.
std::optional<Unit> unit_named(std::string_view name);

}  // namespace roadbalance
