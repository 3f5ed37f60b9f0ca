#pragma once

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/link/block.hpp"

namespace roadbalance {

/// Puts the blocks of each node epoch in sequence: drops repeats, keeps what came early until its turn.
class InSequence {
 public:
  /// A recorder's window is smaller than this.
  static constexpr std::size_t kMostEarly = 8192;

  /// Calls consume(block) for every block whose turn has come.
  /// @throws std::runtime_error naming the node if a block stays missing for kMostEarly others
  template <typename Consume>
  void add(const SealedBlock& block, Consume&& consume) {
    auto& [next, early] = epochs_[{block.header.node, block.header.epoch}];
    if (block.header.sequence < next) return;
    if (block.header.sequence > next) {
      if (early.size() >= kMostEarly)
        throw std::runtime_error("record of node " + std::to_string(block.header.node) + ": block " +
                                 std::to_string(next) + " is missing");
      early.emplace(block.header.sequence, block);
      return;
    }
    consume(block);
    ++next;
    while (!early.empty() && early.begin()->first == next) {
      consume(early.begin()->second);
      early.erase(early.begin());
      ++next;
    }
  }

 private:
  struct Epoch {
    std::int64_t next = 1;
    std::map<std::int64_t, SealedBlock> early;
  };
  std::map<std::pair<std::int32_t, std::int64_t>, Epoch> epochs_;
};

}  // namespace roadbalance
