#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/record/journal_counters.hpp"

namespace roadbalance {

/// Compares each journal entry with the blocks that stand in the record since the entry before: their number,
/// order and place, which the node's own CRCs do not cover.
class JournalCheck {
 public:
  void add(const SealedBlock& block) { since_entry_.add(block); }
  void add(const Journal& entry);
  /// The record's first segments, which end at these positions, are not here.  If the retention mode has
  /// deleted them, entries that begin in them prove nothing about the remaining blocks alone; notes that come
  /// later decide whether it has.
  void begin_behind(const std::map<NodeEpoch, RecordState::Epoch>& before) { before_ = before; }
  /// It has not: those entries count.
  void nothing_was_deleted();
  /// A recorder began: blocks before this point that are in no entry were appended just before its
  /// predecessor was killed.
  void restart() {
    since_entry_ = {};
    counted_.clear();
  }

  /// The losses of each node epoch: those that the node counted, by all entries, and its recorder in its last
  /// run.
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

  JournalCounters since_entry_;
  std::map<NodeEpoch, RecordState::Epoch> before_;
  std::map<NodeEpoch, Losses> losses_, counted_;  // the second: of this run of the recorder
  std::int64_t entries_ = 0;
  Contradictions contradictions_;
  Contradictions unless_deleted_;  // of entries that begin before the first segment here
};

}  // namespace roadbalance
