#pragma once

#include <chrono>
#include <string>

#include "common/config/vehicle_config.hpp"
#include "tools/rb/bus_view.hpp"

namespace roadbalance {

/// A demo whose recorder, nodes or analyser have not begun by then never will.
inline constexpr std::chrono::seconds kDemoStart{60};

/// Who has not begun its work, as far as is heard on the bus: programs that do not understand each other wait
/// for ever.  Empty: all have.
std::string who_is_idle(const VehicleConfig& vehicle, const BusView& view);

}  // namespace roadbalance
