#pragma once

#include <nlohmann/json.hpp>

#include "tools/views/bus_view.hpp"

namespace roadbalance {

/// One line of rb watch --json: "wheels" and "compensation" (null without an estimate), and "recorders",
/// "nodes", "clocks" and "orders", an object for each that is heard.  A value that is not known is null.
nlohmann::ordered_json watch_json(const BusView& view);

/// The objects of these.
nlohmann::ordered_json recorder_json(const RecorderStatus& status);
nlohmann::ordered_json node_json(const Heartbeat& beat, std::optional<double> memory_left_s);
nlohmann::ordered_json clock_json(const ClockFit& fit);

}  // namespace roadbalance
