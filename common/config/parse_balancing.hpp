#pragma once

#include <vector>

#include "common/config/section.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// [weights]; no place.
WeightStock parse_stock(Section& root);

/// [[wheel.place]] and [[wheel.weight]] of a [[wheel]].
/// @param wheel  its radii are known
void parse_places(Section& section, const WeightStock& stock, WheelConfig& wheel);

/// [limits].
BalanceLimits parse_limits(Section& root);

/// [[seat]].
std::vector<SeatConfig> parse_seats(Section& root);

}  // namespace roadbalance
