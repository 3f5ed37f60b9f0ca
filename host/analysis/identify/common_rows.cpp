#include "host/analysis/identify/common_rows.hpp"

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

void CommonRows::add(const NodeConfig& node, bool alone, std::int32_t unusable) {
  streams_.emplace_back(node.id, alone, delays_of(node));
  unusable_.push_back(unusable);
}

GridStream* CommonRows::stream_of(std::int32_t node) {
  const auto found = std::ranges::find(streams_, node, &GridStream::node);
  return found == streams_.end() ? nullptr : &*found;
}

bool CommonRows::take(const SealedBlock& block) {
  return block.kind == BlockKind::kScan && stream_of(block.header.node) && take(decode_scan(block));
}

bool CommonRows::take(const ScanBlock& block) {
  GridStream* const stream = stream_of(block.header.node);
  if (!stream || block.header.scans == 0) return false;
  stream->take(block, grid_);
  return true;
}

bool CommonRows::take(const ClockFit& fit) {
  GridStream* const stream = stream_of(fit.node);
  if (stream) stream->take(fit, grid_);
  return stream != nullptr;
}

std::string CommonRows::refusal() const {
  for (const GridStream& stream : streams_)
    if (std::string why = stream.refusal(); !why.empty()) return why;
  return {};
}

/// Removes rows that are used, or must not be, from the front.  False if nothing is left.
bool CommonRows::drop_unusable(std::size_t which) {
  GridStream& stream = streams_[which];
  while (!stream.rows.empty()) {
    GridRows& front = stream.rows.front();
    // It must not be forgotten where the row that bore it is passed over.
    stream.restarted = std::exchange(front.restart, false) || stream.restarted;
    stream.spoiled = (front.overload & unusable_[which]) >> kChannels != 0 || stream.spoiled;
    if ((front.overload & unusable_[which]) == 0 && stream.row < front.rows) return true;
    stream.rows.pop_front();
    stream.row = 0;
  }
  return false;
}

/// Passes over rows that another node lacks.  False if a node has none.
bool CommonRows::align() {
  for (;;) {
    std::int64_t newest = std::numeric_limits<std::int64_t>::min();
    for (std::size_t which = 0; which < streams_.size(); ++which) {
      if (!drop_unusable(which)) return false;
      newest = std::max(newest, next_index(streams_[which]));
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

std::optional<CommonRows::Run> CommonRows::next() {
  if (!align()) return std::nullopt;
  Run run{.first_index = next_index(streams_.front()), .rows = GridRows::kMost, .restart = false};
  run.restart = run.first_index != expected_;
  for (auto& stream : streams_) {
    run.rows = std::min(run.rows, stream.rows.front().rows - stream.row);
    run.restart = std::exchange(stream.restarted, false) || run.restart;
    run.spoiled = std::exchange(stream.spoiled, false) || run.spoiled;
  }
  return run;
}

void CommonRows::use(const Run& run) {
  for (auto& stream : streams_) stream.row += run.rows;
  expected_ = run.first_index + run.rows;
}

void CommonRows::drop_what_nobody_meets() {
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
