#pragma once

#include <cstdint>
#include <stop_token>

#include "common/clock/clock_socket.hpp"
#include "common/frontend/front_end.hpp"

namespace roadbalance {

/// Process: tells who asks what time it is on this node.
///
/// Each question of this node and epoch gets an answer and, where the kernel stamped the answer's sending, a
/// follow-up with that stamp.  At most kMostAnswers a second are given: a flood costs the node no more than
/// that.  Ends when told to stop.
void answer_clock(std::stop_token stop, ClockSocket& socket, std::int32_t node, std::int64_t epoch,
                  const FrontEnd& front_end);

inline constexpr int kMostAnswers = 400;

}  // namespace roadbalance
