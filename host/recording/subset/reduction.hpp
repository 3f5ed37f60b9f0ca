#pragma once

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The largest factor by which a recording of this vehicle is reduced: the new rate is more than twice the
/// filter's cutoff.  Below that the filter of vehicle.toml would no longer be the one that keeps the samples
/// from aliasing, and nodes that replay them compute with it.
/// @return 1: it cannot be reduced
int largest_reduction(const VehicleConfig& vehicle);

}  // namespace roadbalance
