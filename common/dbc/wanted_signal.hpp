#pragma once

#include "common/config/vehicle_config.hpp"
#include "common/dbc/dbc.hpp"

namespace roadbalance {

/// Where a signal that vehicle.toml asks for stands in a DBC file.
struct WantedSignal {
  const DbcMessage* message;  ///< of the Dbc it was sought in
  const DbcSignal* signal;
  double factor;  ///< from the file's unit to the quantity's
};

/// @throws ConfigError naming the signal and its line in the DBC file: not there, in a message longer than
/// one
///         frame, or of a unit that does not go with its quantity
WantedSignal find_wanted(const SignalConfig& wanted, const VehicleConfig& vehicle, const Dbc& dbc);

}  // namespace roadbalance
