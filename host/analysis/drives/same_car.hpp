#pragma once

#include <optional>
#include <string>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The difference of two vehicle.toml that keeps their drives from being one estimate, as "key: 40 there, 41
/// here"; nothing: they are of one car with sensors, zero marks and weights at the same places.
///
/// Not compared is what each drive's samples are brought to units by (scale, offset, delay, filter, rate of
/// the scans), how it is wired, and what only concerns the remedy of an unbalance (limits, stock, seats,
/// rotors). Numbers are compared as they are written.
std::optional<std::string> difference_of_cars(const VehicleConfig& there, const VehicleConfig& here);

}  // namespace roadbalance
