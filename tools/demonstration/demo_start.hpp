#pragma once

#include <chrono>
#include <string>

#include "common/config/vehicle_config.hpp"
#include "tools/views/bus_view.hpp"

namespace roadbalance {

/// A demo whose recorder, nodes or analyser have not begun by then never will.
inline constexpr std::chrono::seconds kDemoStart{60};

/// The programs that have not begun their work, by what is heard on the bus: programs that do not understand
/// each other wait for ever.  Empty: all have.
std::string who_is_idle(const VehicleConfig& vehicle, const BusView& view);

}  // namespace roadbalance
