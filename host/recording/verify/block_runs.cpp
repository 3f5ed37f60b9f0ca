#include "host/recording/verify/block_runs.hpp"

#include <numeric>

namespace roadbalance {

bool BlockRuns::goes_on(const Run& run, const BlockEntry& entry) {
  const BlockEntry& first = run.first;
  if (run.blocks == kMostBlocks || first.kind != BlockKind::kScan || entry.kind != BlockKind::kScan ||
      entry.scans != first.scans)
    return false;
  // The number behind the last one; a damaged record may hold any number.
  const auto blocks = static_cast<std::int64_t>(run.blocks);
  std::int64_t scans = 0, sequence = 0, first_scan = 0;
  return !__builtin_mul_overflow(blocks, first.scans, &scans) &&
         !__builtin_add_overflow(first.sequence, blocks, &sequence) &&
         !__builtin_add_overflow(first.first_scan, scans, &first_scan) && entry.sequence == sequence &&
         entry.first_scan == first_scan;
}

void BlockRuns::add(const BlockEntry& entry) {
  if (!runs_.empty() && goes_on(runs_.back(), entry))
    ++runs_.back().blocks;
  else
    runs_.push_back({entry, crcs_.size(), 1});
  crcs_.push_back(entry.crc);
}

BlockEntry BlockRuns::entry_of(const Run& run, std::size_t n) const {
  BlockEntry entry = run.first;
  entry.sequence += static_cast<std::int64_t>(n);
  entry.first_scan += static_cast<std::int64_t>(n) * entry.scans;
  entry.crc = crcs_[run.first_crc + n];
  return entry;
}

std::vector<std::size_t> BlockRuns::by_first() const {
  std::vector<std::size_t> order(runs_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
    const std::int64_t first_a = runs_[a].first.sequence, first_b = runs_[b].first.sequence;
    return first_a != first_b ? first_a < first_b : a < b;
  });
  return order;
}

/// End of the runs whose numbers overlap with those of the runs before them.
std::size_t BlockRuns::end_of_overlap(const std::vector<std::size_t>& order, std::size_t begin) const {
  std::int64_t last = last_sequence(runs_[order[begin]]);
  std::size_t end = begin + 1;
  for (; end < order.size() && runs_[order[end]].first.sequence <= last; ++end)
    last = std::max(last, last_sequence(runs_[order[end]]));
  return end;
}

void BlockRuns::expand(std::vector<std::size_t> runs, std::vector<BlockEntry>& mixed) const {
  std::sort(runs.begin(), runs.end());  // as they arrived
  mixed.clear();
  for (const std::size_t run : runs)
    for (std::size_t n = 0; n < runs_[run].blocks; ++n) mixed.push_back(entry_of(runs_[run], n));
  std::stable_sort(mixed.begin(), mixed.end(),
                   [](const BlockEntry& a, const BlockEntry& b) { return a.sequence < b.sequence; });
}

}  // namespace roadbalance
