#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>

#include "common/frontend/front_end.hpp"
#include "firmware/clock_place.hpp"

namespace roadbalance {

/// Process: answers the question what time it is on this node.
///
/// Each question of this node and epoch gets an answer and, where the kernel stamped the answer's sending, a
/// follow-up with that stamp.  At most kMostAnswers a second are given: a flood costs the node no more than
/// that.  Follows the machine's address once a second.  Ends when asked to stop.
/// @param warn  gets why the clock cannot be asked
void answer_clock(std::stop_token stop, ClockPlace& place, std::int32_t node, std::int64_t epoch,
                  const FrontEnd& front_end, const std::function<void(const std::string&)>& warn);

inline constexpr int kMostAnswers = 400;

}  // namespace roadbalance
