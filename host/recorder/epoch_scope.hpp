#pragma once

#include <cstdint>
#include <vector>

#include "common/bus/control_messages.hpp"
#include "common/record/recorded_clocks.hpp"

namespace roadbalance {

/// The node measures, or has ended and keeps blocks that are not known to be on the disk.
bool holds_samples(const Heartbeat& heartbeat);

/// The lowest and the highest number of a recording's recorders.
struct IncarnationRange {
  std::int64_t first = 0, last = 0;
};

/// Which node epochs belong to a recording.  By default every one heard; one that is silent for long in the
/// end has died.
struct EpochScope {
  /// Nothing but these: the rest of a recording that is over.  They end, even if their start never came: the
  /// node's next epoch is free for the next recording.  Empty: every epoch.
  std::vector<NodeEpoch> only{};
  /// Never these: their rest belongs to recordings before.
  std::vector<NodeEpoch> not_these{};
  /// Nor those that are heard to hold samples for one of these: they were started for a recording that is
  /// over, and were not known when it ended.
  std::vector<IncarnationRange> not_started_by{};
  /// Nothing more comes of these; the end declares their crash unless the record has their end.
  std::vector<NodeEpoch> given_up{};
  /// An epoch that is only silent in the end stays open: its rest is fetched when the node is back.  One that
  /// is silent while a later epoch of its node lives has died all the same.
  bool leaves_open = false;

  bool has(const NodeEpoch& epoch) const;
  /// Recorders of a recording before had this incarnation.
  bool is_former(std::int64_t incarnation) const;
};

}  // namespace roadbalance
