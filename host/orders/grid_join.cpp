#include "host/orders/grid_join.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

std::int64_t next_index(const GridStream& stream) {
  return stream.rows.front().first_index + stream.row;
}

}  // namespace

GridJoin::GridJoin(const std::vector<const NodeConfig*>& nodes, Emit emit, double longest_wait_s)
    : sample_(nodes.size()), longest_wait_s_(longest_wait_s), emit_(std::move(emit)) {
  for (const NodeConfig* const node : nodes)
    streams_.emplace_back(node->id, nodes.size() == 1, delays_of(*node));
}

GridStream* GridJoin::stream_of(std::int32_t node) {
  const auto found = std::ranges::find(streams_, node, &GridStream::node);
  return found == streams_.end() ? nullptr : &*found;
}

void GridJoin::consume(const SealedBlock& block) {
  if (block.kind != BlockKind::kScan || block.header.scans == 0) return;
  GridStream* const stream = stream_of(block.header.node);
  if (!stream) return;
  stream->take(decode_scan(block), grid_);
  emit(*stream);
}

void GridJoin::consume(const ClockFit& fit) {
  GridStream* const stream = stream_of(fit.node);
  if (!stream) return;
  stream->take(fit, grid_);
  emit(*stream);
}

void GridJoin::emit(const GridStream& changed) {
  while (align()) emit_rows();
  drop_what_nobody_meets();
  obstacle_ = changed.obstacle();
}

/// False if nothing is left.
bool GridJoin::drop_used(GridStream& stream) {
  while (!stream.rows.empty()) {
    GridRows& front = stream.rows.front();
    // It must not be forgotten where the row that bore it is passed over.
    stream.restarted = std::exchange(front.restart, false) || stream.restarted;
    if (stream.row < front.rows) return true;
    stream.rows.pop_front();
    stream.row = 0;
  }
  return false;
}

/// Passes over rows that another node lacks.  False if a node has none.
bool GridJoin::align() {
  for (;;) {
    std::int64_t newest = std::numeric_limits<std::int64_t>::min();
    for (auto& stream : streams_) {
      if (!drop_used(stream)) return false;
      newest = std::max(newest, next_index(stream));
    }
    bool aligned = true;
    for (auto& stream : streams_) {
      const std::int64_t behind = newest - next_index(stream);
      aligned = aligned && behind == 0;
      stream.row += std::min(behind, stream.rows.front().rows - stream.row);
    }
    if (aligned) return true;
  }
}

void GridJoin::emit_rows() {
  std::int64_t rows = GridRows::kMost;
  const std::int64_t first = next_index(streams_.front());
  bool restart = first != expected_;
  for (auto& stream : streams_) {
    rows = std::min(rows, stream.rows.front().rows - stream.row);
    restart = std::exchange(stream.restarted, false) || restart;
  }
  for (std::int64_t row = 0; row < rows; ++row) {
    for (std::size_t n = 0; n < streams_.size(); ++n) {
      const GridRows& front = streams_[n].rows.front();
      sample_[n] = {&front.counts[static_cast<std::size_t>(streams_[n].row + row)], front.overload,
                    front.quality};
    }
    emit_({.restart = restart && row == 0, .sample = sample_});
  }
  for (auto& stream : streams_) stream.row += rows;
  expected_ = first + rows;
}

void GridJoin::drop_what_nobody_meets() {
  const double longest =
      longest_wait_s_ * 1e12 / static_cast<double>(std::max<std::int64_t>(grid_.period_ps, 1));
  for (auto& stream : streams_)
    while (!stream.rows.empty() &&
           static_cast<double>(stream.rows.back().first_index - stream.rows.front().first_index) > longest) {
      stream.rows.pop_front();
      stream.row = 0;
      stream.restarted = true;
    }
}

}  // namespace roadbalance
