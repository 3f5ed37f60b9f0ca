#pragma once

#include <map>
#include <optional>

#include "common/record/record_state.hpp"
#include "common/types/blocks.hpp"

namespace roadbalance {

/// The sum of each node epoch's blocks so far, against the one in the node's end.
class EpochSums {
 public:
  EpochSums() = default;
  /// Goes on where a record stands.
  explicit EpochSums(const RecordState& recovered);

  /// The next block of its epoch.  Once one is not the node's own there is no sum.
  void take(const SealedBlock& block);
  void lose(const NodeEpoch& epoch) { sums_[epoch].reset(); }

  /// Whether the sum is the one in this end; nothing: there is no sum.
  std::optional<bool> agrees(const SealedBlock& end) const;

 private:
  std::map<NodeEpoch, std::optional<BlockSum>> sums_;
};

}  // namespace roadbalance
