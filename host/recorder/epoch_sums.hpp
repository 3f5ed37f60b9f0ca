#pragma once

#include <map>
#include <optional>

#include "common/link/blocks.hpp"
#include "common/record/record_state.hpp"

namespace roadbalance {

/// Of each node epoch the sum of its blocks so far, against what the node's end says of them.
class EpochSums {
 public:
  EpochSums() = default;
  /// Goes on where a record stands.
  explicit EpochSums(const RecordState& recovered);

  /// The next block of its epoch.  Once one is not the node's own there is no sum.
  void take(const SealedBlock& block);
  void lose(const NodeEpoch& epoch) { sums_[epoch].reset(); }

  /// Whether the sum is what this end says; nothing: there is no sum.
  std::optional<bool> agrees(const SealedBlock& end) const;

 private:
  std::map<NodeEpoch, std::optional<BlockSum>> sums_;
};

}  // namespace roadbalance
