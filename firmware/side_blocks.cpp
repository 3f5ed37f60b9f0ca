#include "firmware/side_blocks.hpp"

#include <algorithm>

namespace roadbalance {
namespace {

// Signals reach the record soon after their scans, and edges where so many are worth a block of 1.3 kB: 4
// bytes each, with all that the record puts around it.
constexpr std::int64_t kSoon_ns = 200'000'000, kLongestEdgeBlock_ns = 1'000'000'000;
constexpr std::int32_t kEdgesThatPay = 350;

}  // namespace

std::size_t SideBlocks::most_blocks(std::size_t edges, std::size_t signals, std::int64_t all_ns) noexcept {
  const std::int64_t by_age = all_ns / kLongestEdgeBlock_ns + all_ns / kSoon_ns;
  return edges / (kEdgeBytesPerBlock / kMostEdgeCodeBytes) + signals / kSamplesPerBlock +
         static_cast<std::size_t>(by_age);
}

void SideBlocks::add(const Edge& edge, NodeTime now) noexcept {
  if (dropped_.pass(edge, [&](const Edge& e) { return place(e, edge_block_, now); })) return;
  static_cast<void>(dropped_.drop(edge.line));
  lose(edge.time, now);
}

void SideBlocks::add(const SignalSample& sample, NodeTime now) noexcept {
  if (!place(sample, signal_block_, now)) lose(sample.time, now);
}

bool SideBlocks::write_all(NodeTime now) noexcept {
  return write(edge_block_, now) && write(signal_block_, now);
}

void SideBlocks::write_old(NodeTime now) noexcept {
  const auto write_if_old = [&](auto& block, std::int64_t longest_ns) {
    if (to_ns(now) - block.header.time_ns > longest_ns) static_cast<void>(write(block, now));
  };
  write_if_old(edge_block_, edge_block_.edges < kEdgesThatPay ? kLongestEdgeBlock_ns : kSoon_ns);
  write_if_old(signal_block_, kSoon_ns);
}

template <typename Item, typename Block>
bool SideBlocks::place(const Item& item, Block& block, NodeTime now) noexcept {
  return block.add(item) || (write(block, now) && block.add(item));
}

/// A block stands beside the scans that were sealed last and before those of a gap.
template <typename Block>
bool SideBlocks::write(Block& block, NodeTime now) noexcept {
  if (block.empty()) return true;
  const GapBlock* const gap = tiling_.gap();
  block.header = writer_.header(gap ? gap->header.first_scan : tiling_.next_scan(), 0, block.header.time_ns);
  if (!writer_.write_description(now) || !writer_.write(block)) return false;
  block = Block{};
  return true;
}

/// Neither the block nor the sink has room.
void SideBlocks::lose(NodeTime time, NodeTime now) noexcept {
  tiling_.lose_beside(now);
  // A stamp that runs far ahead would keep the gap open for as long.
  lost_through_ = std::max(lost_through_, std::min(time, now + NodeClock::duration(kLongestEdgeBlock_ns)));
}

}  // namespace roadbalance
