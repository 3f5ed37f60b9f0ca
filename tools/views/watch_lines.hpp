#pragma once

#include <string>
#include <vector>

#include "tools/views/bus_view.hpp"

namespace roadbalance {

/// Text of rb watch for all that it has heard.
std::vector<std::string> watch_lines(const BusView& view);

/// Its part on one recorder: how it stands, what a person should know or do, and if the nodes obey others
/// only, whom.
/// @param beats  the nodes' last ones
std::vector<std::string> recorder_lines(const RecorderStatus& status,
                                        const std::map<std::int32_t, Heartbeat>& beats);

}  // namespace roadbalance
