#pragma once

#include "common/frontend/registry.hpp"
#include "firmware/backends/socketcan/can_intake.hpp"

namespace roadbalance {

/// Opens "can:INTERFACE" as the node's [[node.can]] describes it: its signals beside the scans of another
/// device or, with accelerometer_id, the scans of that module with the signals.
///
/// @param warn  see CanIntake
/// @throws ConfigError naming what is wrong with the wiring or the DBC file; CanError naming the interface,
///         with the command that mends it; std::system_error
OpenedDevice open_can(const FrontEndRequest& request, const CanIntake::Warn& warn);

}  // namespace roadbalance
