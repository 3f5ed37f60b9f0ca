#pragma once

#include <string>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// Why wheels have no angle although the car's bus reports them, or why none has one; empty: there is nothing
/// to report.  For people.
///
/// A wheel's speed gives orders and magnitudes.  The place of a weight takes an angle from a zero mark on the
/// wheel, which no speed and no pulse counter of a bus carries.
std::string why_no_angle(const VehicleConfig& vehicle);

}  // namespace roadbalance
