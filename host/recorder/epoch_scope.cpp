#include "host/recorder/epoch_scope.hpp"

#include <algorithm>

namespace roadbalance {

bool EpochScope::has(const NodeEpoch& epoch) const {
  if (std::ranges::find(not_these, epoch) != not_these.end()) return false;
  return only.empty() || std::ranges::find(only, epoch) != only.end();
}

}  // namespace roadbalance
