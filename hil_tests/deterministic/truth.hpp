#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/types/block.hpp"

namespace roadbalance::test {

/// Samples and blocks that one node epoch really took and sealed.
struct EpochTruth {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t scans = 0;  ///< taken between start and stop or death, those that the device lost included
  bool ended = false;      ///< its end is sealed
  bool killed = false;
  bool gone = false;  ///< its program ended in order: its owner had everything, but others may not have heard
  int openings = 0;   ///< runs of the node that called it theirs; one, if all is well
  std::int64_t promised = 0;    ///< called durable by an acknowledgement of any recorder
  bool gave_up = false;         ///< its own disk failed: it may give back blocks that were not called durable
  std::int64_t started_by = 0;  ///< incarnation of the recorder that it obeyed when it began to measure
  /// Incarnations of the recorders it gave blocks back to or took as its owner, each change.
  std::vector<std::int64_t> obeyed;
  void obeys(std::int64_t incarnation) {
    if (obeyed.empty() || obeyed.back() != incarnation) obeyed.push_back(incarnation);
  }
  struct Block {
    std::uint32_t crc = 0;
    std::int64_t sealed_ns = 0;
  };
  std::vector<Block> blocks;  ///< [sequence - 1 - dropped]
  std::int64_t dropped = 0;   ///< checked long ago, kept no longer
  void drop_through(std::int64_t sequence);

  std::int64_t next() const { return dropped + static_cast<std::int64_t>(blocks.size()) + 1; }
  const Block* block(std::int64_t sequence) const {
    const std::int64_t at = sequence - 1 - dropped;
    return at < 0 || at >= static_cast<std::int64_t>(blocks.size()) ? nullptr
                                                                    : &blocks[static_cast<std::size_t>(at)];
  }
};

/// Events of a run as they really were, and every promise that was seen broken.
class Truth {
 public:
  EpochTruth& open(std::int32_t node, std::int64_t epoch);
  EpochTruth* find(std::int32_t node, std::int64_t epoch);
  /// In order of node and epoch.
  const std::map<std::pair<std::int32_t, std::int64_t>, EpochTruth>& epochs() const { return epochs_; }

  /// `checked(node, epoch)`: the last sequence that no check will ask for again.
  template <typename Checked>
  void drop_checked(Checked&& checked) {
    for (auto& [key, epoch] : epochs_) epoch.drop_through(checked(key.first, key.second));
  }
  void sealed(EpochTruth& epoch, const SealedBlock& block, std::int64_t now_ns);

  /// A recorder of this incarnation writes this recording.
  void leads(std::int64_t incarnation, const std::string& recording) {
    leads_[incarnation].insert(recording);
  }
  /// The epoch was started for this recording, by incarnations: a recorder that fetches the rest of one may
  /// have the number of another when the wall clock was set back.
  bool may_be_in(const EpochTruth& epoch, const std::string& recording) const;

  /// A node measures from an instant to another.
  struct Measured {
    std::int32_t node = 0;
    std::int64_t from_ns = 0, to_ns = 0;  ///< 0: it goes on
    AbsenceCause end = AbsenceCause::kNone;
  };
  void begins(std::int32_t node) { measured_.push_back({.node = node, .from_ns = now_ns_}); }
  void ends(std::int32_t node, AbsenceCause cause);
  const std::vector<Measured>& measured() const { return measured_; }

  /// A broken promise; the first few are kept.
  void fault(const std::string& what);
  void set_now(std::int64_t now_ns) { now_ns_ = now_ns; }
  const std::vector<std::string>& faults() const { return faults_; }
  std::int64_t fault_count() const { return fault_count_; }
  /// Lost inside a gap.
  void lost_edge() { ++lost_edges_; }
  void started_late() { ++late_starts_; }
  void lost_signal() { ++lost_signals_; }
  std::int64_t lost_edges() const { return lost_edges_; }
  std::int64_t late_starts() const { return late_starts_; }
  std::int64_t lost_signals() const { return lost_signals_; }
  std::int64_t blocks_sealed() const { return blocks_sealed_; }

 private:
  std::map<std::pair<std::int32_t, std::int64_t>, EpochTruth> epochs_;
  std::map<std::int64_t, std::set<std::string>> leads_;
  std::vector<Measured> measured_;  // in order of time
  std::vector<std::string> faults_;
  std::int64_t fault_count_ = 0;
  std::int64_t blocks_sealed_ = 0;
  std::int64_t lost_edges_ = 0;
  std::int64_t late_starts_ = 0;
  std::int64_t lost_signals_ = 0;
  std::int64_t now_ns_ = 0;
};

/// The CRC a sealed block ends with.
std::uint32_t crc_of(const SealedBlock& block);

}  // namespace roadbalance::test
