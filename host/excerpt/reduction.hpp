#pragma once

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The largest factor a recording of this vehicle is reduced by: what is left is more than twice the filter's
/// cutoff.  What vehicle.toml says of the filter would not be true of samples that the filter alone did not
/// keep from folding, and nodes that replay them compute with it.
/// @return 1: it is not reduced at all
int largest_reduction(const VehicleConfig& vehicle);

}  // namespace roadbalance
