#pragma once

#include <cstdint>

#include "firmware/acquire.hpp"

namespace roadbalance {

/// The proof that a node lives: the loop that samples and the loop that sends both turn.
class LifeWatch {
 public:
  /// @param link  outlives it
  explicit LifeWatch(const AcquireLink& link) : link_(link) {}

  /// True if acquire, unless it has ended, and uplink have turned since this was true last.
  bool both_turned();

 private:
  const AcquireLink& link_;
  std::int64_t acquire_turns_ = 0, uplink_turns_ = 0;
};

}  // namespace roadbalance
