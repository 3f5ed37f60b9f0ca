#pragma once

#include "common/config/vehicle_config.hpp"
#include "common/multibody/description.hpp"

namespace roadbalance {

/// The description that [model] of a vehicle.toml stands for: its own file, or the shipped seven_dof with the
/// vehicle's numbers and, in place of the description's sensors, its accelerometers (mount "body" or a
/// wheel).
/// @throws ConfigError, std::system_error for a file of its own that cannot be used or read
Description description_of(const VehicleConfig& vehicle);

}  // namespace roadbalance
