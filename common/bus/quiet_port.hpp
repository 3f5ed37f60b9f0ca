#pragma once

#include <chrono>
#include <string>

namespace roadbalance {

/// True if no node, no recorder and no replay is heard on the bus for so long.
/// @throws std::runtime_error naming the URL if there is no bus
bool is_quiet(const std::string& url, std::chrono::milliseconds listen);

/// A port whose bus nobody uses, so that two demonstrations do not mix.  Listens for a third of a second, in
/// which every node, idle or not, beats three times.
///
/// @param asked  0: one is chosen
/// @throws std::runtime_error if the port asked for is in use, or no free one was found
int quiet_port(int asked);

}  // namespace roadbalance
