#include "tools/rb/edge_listener.hpp"

#include <span>
#include <string_view>

#include "common/bus/codec.hpp"

namespace roadbalance {

EdgeListener::EdgeListener(const std::string& url, std::int32_t node, int line)
    : bus_(url), node_(node), line_(line) {
  const auto hear = [this](std::string_view, std::span<const std::uint8_t> bytes) { take(bytes); };
  bus_.subscribe("RB_BLOCK_" + std::to_string(node) + "_.*", hear);
  bus_.subscribe(preview_channel(node), hear);
}

void EdgeListener::take(std::span<const std::uint8_t> bytes) {
  if (accept(bytes, *block_) != Refusal::kNone || block_->header.node != node_) return;
  const BlockHeader& header = block_->header;
  if (header.sequence == 0) {
    preview_ = true;
    return;
  }
  const bool same_epoch = header.epoch == epoch_;
  if (same_epoch && header.sequence <= sequence_) return;  // repaired for the recorder
  const bool missed = epoch_ != 0 && (!same_epoch || header.sequence != sequence_ + 1);
  epoch_ = header.epoch;
  sequence_ = header.sequence;
  if (missed || block_->kind == BlockKind::kGap)
    edges.push_back({node_time_from_ns(header.time_ns), static_cast<std::uint8_t>(line_), EdgeKind::kLost});
  if (block_->kind != BlockKind::kEdge) return;
  for (const Edge& edge : decode_edge(*block_).unpack())
    if (edge.line == line_) edges.push_back(edge);
}

}  // namespace roadbalance
