#pragma once

#include <vector>

#include "common/record/recorded_clocks.hpp"

namespace roadbalance {

/// Which node epochs belong to a recording.  By default: every one heard, and what is silent for long in the
/// end has died.
struct EpochScope {
  /// Nothing but these: the rest of a recording that is over.  They end, even if their start never came: the
  /// node's next epoch is free for the next recording.  Empty: every epoch.
  std::vector<NodeEpoch> only{};
  /// Never these: their rest belongs to recordings before.
  std::vector<NodeEpoch> not_these{};
  /// Nothing more comes of these; the end declares their crash unless the record has their end.
  std::vector<NodeEpoch> given_up{};
  /// What is only silent in the end stays open: somebody fetches its rest when the node is back.  What is
  /// silent while a later epoch of its node lives has died all the same.
  bool leaves_open = false;

  bool has(const NodeEpoch& epoch) const;
};

}  // namespace roadbalance
