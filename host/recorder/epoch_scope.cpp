#include "host/recorder/epoch_scope.hpp"

#include <algorithm>

namespace roadbalance {

bool holds_samples(const Heartbeat& heartbeat) {
  return heartbeat.state == NodeState::kStarted || (heartbeat.is_over() && heartbeat.base < heartbeat.next);
}

bool EpochScope::has(const NodeEpoch& epoch) const {
  if (std::ranges::find(not_these, epoch) != not_these.end()) return false;
  return only.empty() || std::ranges::find(only, epoch) != only.end();
}

bool EpochScope::is_former(std::int64_t incarnation) const {
  return std::ranges::any_of(not_started_by, [incarnation](const IncarnationRange& range) {
    return range.first <= incarnation && incarnation <= range.last;
  });
}

}  // namespace roadbalance
