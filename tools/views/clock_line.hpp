#pragma once

#include <cstdio>
#include <string>

#include "common/types/exchange.hpp"

namespace roadbalance {

/// How a node's clock stands to the host's, as one line for displays.
inline std::string clock_line(const ClockFit& fit) {
  constexpr const char* kStates[] = {"not known yet", "locked", "held over"};
  char text[200];
  if (!fit.is_known())
    std::snprintf(text, sizeof text, "node %d clock %s: %lld answers, %lld questions without", fit.node,
                  kStates[0], static_cast<long long>(fit.exchanges), static_cast<long long>(fit.unanswered));
  else
    std::snprintf(text, sizeof text,
                  "node %d clock %s to %.1f us, drift %+.2f ppm, round trip %.1f us, breaks %lld", fit.node,
                  kStates[static_cast<int>(fit.state)], 1e6 * fit.uncertainty_s, 1e6 * fit.drift,
                  1e6 * fit.round_trip_s, static_cast<long long>(fit.breaks));
  return text;
}

}  // namespace roadbalance
