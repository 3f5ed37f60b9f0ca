#include "host/analysis/calibration/line_edges.hpp"

#include "common/bus/codec.hpp"

namespace roadbalance {

void LineEdges::take(const SealedBlock& block) {
  const BlockHeader& header = block.header;
  if (header.node != node_) return;
  if (header.sequence == 0) {
    preview_ = true;
    return;
  }
  const bool same_epoch = header.epoch == epoch_;
  if (same_epoch && header.sequence <= sequence_) return;  // repaired for the recorder
  const bool missed = epoch_ != 0 && (!same_epoch || header.sequence != sequence_ + 1);
  epoch_ = header.epoch;
  sequence_ = header.sequence;
  if (missed || block.kind == BlockKind::kGap)
    edges.push_back({node_time_from_ns(header.time_ns), static_cast<std::uint8_t>(line_), EdgeKind::kLost});
  if (block.kind != BlockKind::kEdge) return;
  for (const Edge& edge : decode_edge(block).unpack())
    if (edge.line == line_) edges.push_back(edge);
}

}  // namespace roadbalance
