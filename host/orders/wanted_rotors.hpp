#pragma once

#include <memory>
#include <vector>

#include "host/orders/orders_of_record.hpp"

namespace roadbalance {

/// The analyses that are wanted of a vehicle's recording.
/// @throws ConfigError naming what cannot be analysed, and what can
std::vector<std::unique_ptr<RotorOrders>> wanted_rotors(const VehicleConfig& vehicle,
                                                        const WantedOrders& wanted);

}  // namespace roadbalance
