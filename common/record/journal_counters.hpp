#pragma once

#include <map>
#include <utility>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/record/record_state.hpp"

namespace roadbalance {

/// Makes the journal entries of a record from its blocks in the order in which they are appended: the
/// recorder to write them, rb verify to check them.
///
/// An entry covers the blocks of its node epoch since the entry before, by their place in the record.
class JournalCounters {
 public:
  /// Descriptions (sequence 0) count for nothing.
  void add(const SealedBlock& block);

  /// The entry of one node epoch up to now, begun anew; without blocks since the last one last_sequence is
  /// first_sequence - 1.  Fields that the blocks do not give (time, loss counters) are left at 0.
  Journal take(std::int32_t node, std::int64_t epoch);
  /// Those that have blocks since their last entry, in order.
  std::vector<NodeEpoch> due() const;

 private:
  std::map<NodeEpoch, Journal> open_;
};

}  // namespace roadbalance
