#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/record/journal_tally.hpp"

namespace roadbalance {

/// Compares each journal entry with the blocks that stand in the record since the one before, and that the
/// node's own CRCs say nothing of: their number, order and place.
class JournalCheck {
 public:
  void add(const SealedBlock& block) { tally_.add(block); }
  void add(const Journal& entry);
  /// The record's first segments are not here, which end at these positions.  If the retention mode has
  /// deleted them, entries that begin there say nothing of the rest alone; notes that come later say if it
  /// has.
  void begin_behind(const std::map<NodeEpoch, RecordState::Epoch>& before) { before_ = before; }
  /// It has not: what those entries say counts.
  void nothing_was_deleted();
  /// A recorder began: what stands before and is in no entry was appended just before the one before was
  /// killed.
  void restart() {
    tally_ = {};
    counted_.clear();
  }

  /// What each node epoch has counted of losses, by all entries, and its recorder in its last run.
  struct Losses {
    NodeLosses node{};
    std::int64_t refused = 0, rivals = 0, unsent = 0, disk_failures = 0;
  };
  const std::map<NodeEpoch, Losses>& losses() const { return losses_; }

  std::int64_t entries() const { return entries_; }
  /// By node epoch, in words.
  const std::map<NodeEpoch, std::vector<std::string>>& contradictions() const { return contradictions_; }

 private:
  using Contradictions = std::map<NodeEpoch, std::vector<std::string>>;

  void count_losses(const Journal& entry);
  bool begins_before(const Journal& entry) const;

  JournalTally tally_;
  std::map<NodeEpoch, RecordState::Epoch> before_;
  std::map<NodeEpoch, Losses> losses_, counted_;  // the second: of this run of the recorder
  std::int64_t entries_ = 0;
  Contradictions contradictions_;
  Contradictions unless_deleted_;  // of entries that begin before
};

}  // namespace roadbalance
