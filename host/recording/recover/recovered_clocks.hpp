#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "common/record/recorded_clocks.hpp"

namespace roadbalance {

/// Chooses the clock events of several folders that go into the one record made of them: each exchange and
/// each fit once, where it comes first.  They repeat: segments begin with earlier fits, and a recorder that
/// goes on in its fallback folder writes those again there that may not have reached the first disk.
class RecoveredClocks {
 public:
  /// The next event: whether to write it; true for events of other channels.
  bool is_new(std::string_view channel, std::span<const std::uint8_t> data);

 private:
  // No two of an epoch have both instants in common, whatever begins anew: recorder, host or, by a break, the
  // node's clock.
  using Instants = std::set<std::pair<std::int64_t, std::int64_t>>;

  std::map<NodeEpoch, Instants> exchanges_;  // asked, and received
  std::map<NodeEpoch, Instants> fits_;       // the host's, and the node's
};

}  // namespace roadbalance
