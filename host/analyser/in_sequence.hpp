#pragma once

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/bus/codec.hpp"

namespace roadbalance {

/// Puts the blocks of each node epoch in sequence: drops repeats, keeps what came early until its turn.
///
/// A gap of cause kLostAtNode bears the number of the last lost block and stands for all of them.
class InSequence {
 public:
  /// A recorder's window is smaller than this.
  static constexpr std::size_t kMostEarly = 8192;

  /// Calls consume(block) for every block whose turn has come.
  /// @throws std::runtime_error naming the node if a block stays missing for kMostEarly others
  template <typename Consume>
  void add(const SealedBlock& block, Consume&& consume) {
    Epoch& epoch = epochs_[{block.header.node, block.header.epoch}];
    if (block.header.sequence < epoch.next) return;
    if (block.header.sequence > epoch.next && !stands_for_lost(block)) {
      if (epoch.early.size() >= kMostEarly)
        throw std::runtime_error("record of node " + std::to_string(block.header.node) + ": block " +
                                 std::to_string(epoch.next) + " is missing");
      epoch.early.emplace(block.header.sequence, block);
      return;
    }
    hand_over(epoch, block, consume);
    for (auto first = epoch.early.begin();
         first != epoch.early.end() && (first->first == epoch.next || stands_for_lost(first->second));
         first = epoch.early.begin()) {
      hand_over(epoch, SealedBlock(first->second), consume);
    }
  }

 private:
  struct Epoch {
    std::int64_t next = 1;
    std::map<std::int64_t, SealedBlock> early;
  };

  static bool stands_for_lost(const SealedBlock& block) {
    return block.kind == BlockKind::kGap && decode_gap(block).cause == GapCause::kLostAtNode;
  }

  template <typename Consume>
  static void hand_over(Epoch& epoch, const SealedBlock& block, Consume& consume) {
    consume(block);
    epoch.next = block.header.sequence + 1;
    epoch.early.erase(epoch.early.begin(), epoch.early.lower_bound(epoch.next));
  }

  std::map<std::pair<std::int32_t, std::int64_t>, Epoch> epochs_;
};

}  // namespace roadbalance
