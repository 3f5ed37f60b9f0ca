#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/types/block.hpp"

namespace roadbalance {

/// The facts of a block that a proof needs.
struct BlockEntry {
  std::int64_t sequence = 0;
  std::int64_t first_scan = 0;
  std::int64_t scans = 0;
  std::uint32_t crc = 0;
  BlockKind kind = BlockKind::kScan;
  GapCause cause = GapCause::kRingFull;

  bool operator==(const BlockEntry&) const = default;
};

/// The blocks of a node epoch, kept as they arrive, visited by number.
/// Scan blocks that follow one another take four bytes each, any other up to 56.
class BlockRuns {
 public:
  void add(const BlockEntry& entry);
  bool empty() const { return runs_.empty(); }

  /// Calls `f(entry)` for each, by number; those of the same number in the order of their arrival.
  template <typename F>
  void in_order(F f) const {
    const std::vector<std::size_t> order = by_first();
    std::vector<BlockEntry> mixed;
    for (std::size_t k = 0; k < order.size();) {
      const std::size_t end = end_of_overlap(order, k);
      if (end == k + 1) {
        const Run& run = runs_[order[k]];
        for (std::size_t n = 0; n < run.blocks; ++n) f(entry_of(run, n));
      } else {
        expand({order.begin() + static_cast<std::ptrdiff_t>(k),
                order.begin() + static_cast<std::ptrdiff_t>(end)},
               mixed);
        std::for_each(mixed.begin(), mixed.end(), f);
      }
      k = end;
    }
  }

 private:
  /// Blocks of equally many scans, each of which begins where the one before ends.
  struct Run {
    BlockEntry first;
    std::size_t first_crc = 0;
    std::size_t blocks = 1;
  };
  /// A block that came twice is sorted together with no more than these others.
  static constexpr std::size_t kMostBlocks = 4096;

  static bool goes_on(const Run& run, const BlockEntry& entry);
  static std::int64_t last_sequence(const Run& run) {
    return run.first.sequence + static_cast<std::int64_t>(run.blocks - 1);
  }
  BlockEntry entry_of(const Run& run, std::size_t n) const;
  std::vector<std::size_t> by_first() const;
  std::size_t end_of_overlap(const std::vector<std::size_t>& order, std::size_t begin) const;
  void expand(std::vector<std::size_t> runs, std::vector<BlockEntry>& mixed) const;

  std::deque<Run> runs_;  // no vector: it takes thrice as much while it grows
  std::deque<std::uint32_t> crcs_;
};

}  // namespace roadbalance
