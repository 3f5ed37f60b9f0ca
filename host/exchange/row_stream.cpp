#include "host/exchange/row_stream.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "common/clock/bounded_time.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kUntold = std::numeric_limits<std::int64_t>::min();

bool is_known(const ScanBlock& block, std::size_t converter) {
  if (converter < kAccelerations) return true;
  const int line = static_cast<int>(converter - kAccelerations) / 2;
  return (block.quality & quality_no_reference(line)) == 0;
}

}  // namespace

RowStream::RowStream(const std::filesystem::path& folder, const ExportTable& table, std::size_t group)
    : table_(table), group_(table.group[group]), nodes_(0), last_ns_(kUntold) {
  std::set<std::int32_t> nodes;
  for (const auto& part : group_.part) {
    if (part.converter.empty()) continue;
    nodes.insert(part.node);
    part_.push_back(std::make_unique<NodeBlocks>(folder, part, table.own_clocks));
  }
  nodes_ = std::ssize(nodes);
}

void RowStream::copy(const NodeBlocks& blocks, std::int64_t row, std::int64_t begin) {
  const ExportPart& part = blocks.part();
  const NodeBlocks::Placed& placed = *blocks.now();
  const auto& from = placed.block.counts[static_cast<std::size_t>(row - placed.first_row)];
  const auto at = static_cast<std::size_t>(row - begin);
  std::int32_t* to = counts_.data() + at * group_.channel.size() + part.first_column;
  for (std::size_t c = 0; c < part.converter.size(); ++c)
    if (is_known(placed.block, part.converter[c])) to[c] = from[part.converter[c]];
  if (group_.shared_time) return;
  if (const auto time_ns = blocks.time_ns(row)) time_ns_[at] = *time_ns - table_.start_ns;
}

/// Rows [begin, end), as they are counted in the recording.  @return how many there were
std::int64_t RowStream::fill(NodeBlocks& blocks, std::int64_t begin, std::int64_t end) {
  std::int64_t filled = 0;
  while (const NodeBlocks::Placed* placed = blocks.now()) {
    const std::int64_t first = std::max(placed->first_row, begin);
    const std::int64_t last = std::min(placed->end_row(), end);
    for (std::int64_t row = first; row < last; ++row) copy(blocks, row, begin);
    filled += std::max<std::int64_t>(last - first, 0);
    if (placed->end_row() > end) break;  // the rest belongs to the next rows
    blocks.advance();
  }
  return filled;
}

/// Times of rows that no block told, and never a step back: fits of a clock differ by microseconds.
void RowStream::tell_time(std::int64_t begin) {
  const auto step_ns = static_cast<std::int64_t>(std::llround(1e9 / group_.rate_hz));
  for (std::size_t k = 0; k < time_ns_.size(); ++k) {
    const std::int64_t row = begin + static_cast<std::int64_t>(k);
    std::int64_t& time_ns = time_ns_[k];
    if (group_.shared_time)
      time_ns = time_after_ns(group_.origin_ns, row, group_.period_ps) - table_.start_ns;
    else if (time_ns == kUntold)
      time_ns = last_ns_ == kUntold ? group_.first_ns : last_ns_ + step_ns;
    if (last_ns_ != kUntold) time_ns = std::max(time_ns, last_ns_ + 1);
    last_ns_ = time_ns;
  }
}

ExportRows RowStream::next() {
  const std::int64_t rows = std::min(kRows, group_.rows - row_);
  if (rows <= 0) return {};
  const auto count = static_cast<std::size_t>(rows);
  counts_.assign(count * group_.channel.size(), kMissingCounts);
  time_ns_.assign(count, kUntold);
  const std::int64_t begin = group_.first_row + row_;
  missing_ += nodes_ * rows;
  for (const auto& part : part_) missing_ -= fill(*part, begin, begin + rows);
  tell_time(begin);
  const ExportRows given{.first_row = row_, .time_ns = time_ns_, .counts = counts_};
  row_ += rows;
  return given;
}

}  // namespace roadbalance
