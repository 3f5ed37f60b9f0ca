#pragma once

#include <cstdint>

#include "common/types/block.hpp"

namespace roadbalance {

/// A node's number as messages bear it; 0 is the host.
inline bool is_node(std::int32_t node) {
  return 1 <= node && node <= kLastNode;
}

}  // namespace roadbalance
