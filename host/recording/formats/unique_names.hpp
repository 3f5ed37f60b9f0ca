#pragma once

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The channels of a vehicle as files name them, in which no node stands beside a name: one that two channels
/// have becomes <node>_<name> for both.  It depends on vehicle.toml alone, so that a channel has one name in
/// all recordings of a car, whichever nodes they hold.  Names are alike if they differ in capitals and
/// signs only, since formats differ in what of these they keep.
///
/// @return the vehicle with those names; unused channels keep theirs, for no file has them
VehicleConfig with_unique_names(VehicleConfig vehicle);

}  // namespace roadbalance
