#pragma once

namespace roadbalance {

/// A port whose bus nobody uses, so that two demonstrations do not mix.  Listens for a third of a second, in
/// which every node, idle or not, beats three times.
///
/// @param asked  0: one is chosen
/// @throws std::runtime_error if the port asked for is in use, or no free one was found
int quiet_port(int asked);

}  // namespace roadbalance
