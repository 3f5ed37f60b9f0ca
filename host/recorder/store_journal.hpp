#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/record/journal_counters.hpp"
#include "common/types/blocks.hpp"
#include "host/recorder/recorder_link.hpp"

namespace roadbalance {

/// Makes the journal's entries: for each epoch the blocks recorded since the entry before, with every counter
/// of loss of node and recorder.
class StoreJournal {
 public:
  void add(const SealedBlock& block) { blocks_.add(block); }
  void set_link_counters(LinkCounters counters) { counters_ = std::move(counters); }

  /// Those of epochs with new blocks.
  /// @param with_losses  those of epochs that have lost more since their last entry, behind their last block,
  ///                     too
  std::vector<Journal> entries(bool with_losses, std::int64_t time_us, std::int64_t disk_failures);

  /// Another folder: all that it is given is added again.
  void begin_anew();

 private:
  std::vector<NodeEpoch> due(bool with_losses) const;

  JournalCounters blocks_;
  LinkCounters counters_;
  std::map<NodeEpoch, NodeLosses> last_losses_;  // by the last entries
};

}  // namespace roadbalance
