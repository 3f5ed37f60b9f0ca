#include "firmware/life_watch.hpp"

namespace roadbalance {

bool LifeWatch::both_turned() {
  const std::int64_t acquire_turns = link_.acquire_turns.load(std::memory_order_relaxed);
  const std::int64_t uplink_turns = link_.uplink_turns.load(std::memory_order_relaxed);
  if ((acquire_turns == acquire_turns_ && !link_.ended()) || uplink_turns == uplink_turns_) return false;
  acquire_turns_ = acquire_turns;
  uplink_turns_ = uplink_turns;
  return true;
}

}  // namespace roadbalance
