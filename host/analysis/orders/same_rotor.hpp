#pragma once

#include <string>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// Why a rotor cannot be compared in drives of these two vehicles, naming the key; empty: it can.  A datum
/// may differ (datum_of).
/// @param rotor  a name that both have
std::string difference(const VehicleConfig& one, const VehicleConfig& other, const std::string& rotor);

/// By how far a rotor's angle stands ahead because of its wheels' datums: phases of order h are behind by h
/// times that.  Where the angle is known modulo a turn, so is this.
double datum_of(const VehicleConfig& vehicle, const RotorConfig& rotor);

}  // namespace roadbalance
