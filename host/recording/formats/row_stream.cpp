#include "host/recording/formats/row_stream.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record_reader.hpp"
#include "common/types/bounded_time.hpp"
#include "host/recording/formats/epoch_clock.hpp"
#include "host/recording/in_sequence.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kUnknownTime = std::numeric_limits<std::int64_t>::min();

bool is_known(const ScanBlock& block, std::size_t converter) {
  if (converter < kAccelerations) return true;
  const int line = static_cast<int>(converter - kAccelerations) / 2;
  return (block.quality & quality_no_reference(line)) == 0;
}

}  // namespace

/// The scan blocks of one node epoch, in order, each with its place in its group.
class RowStream::NodeBlocks {
 public:
  /// @param part  outlives it
  /// @param own_clocks  as in its table
  NodeBlocks(const std::filesystem::path& folder, const ExportPart& part, bool own_clocks);

  struct Placed {
    ScanBlock block;
    std::int64_t first_row = 0;  ///< as rows are counted in the recording

    std::int64_t end_row() const { return first_row + block.header.scans; }
  };
  /// The current block; nullptr behind the last.
  const Placed* now() const { return there_ ? &now_ : nullptr; }
  /// The time of one of its rows on the recording's clock; nothing: the node's clock is unknown there.
  std::optional<std::int64_t> time_ns(std::int64_t row) const {
    return clock_.time_ns(now_.block.row_time_ns(row - now_.first_row));
  }
  const ExportPart& part() const { return part_; }
  void advance();

 private:
  void place();

  RecordReader reader_;
  const ExportPart& part_;
  const std::string scans_;  ///< channel
  EpochClock clock_;
  InSequence in_sequence_;
  SealedBlock sealed_;
  Placed now_;
  bool there_ = true;
};

RowStream::NodeBlocks::NodeBlocks(const std::filesystem::path& folder, const ExportPart& part,
                                  bool own_clocks)
    : reader_(folder),
      part_(part),
      scans_(block_channel(part.node, BlockKind::kScan)),
      clock_({part.node, part.epoch}, part.first_fit, own_clocks) {
  reader_.finish();
  advance();
}

void RowStream::NodeBlocks::place() {
  now_.block = decode_scan(sealed_);
  now_.first_row = part_.first_row + sealed_.header.first_scan - part_.first_scan;
}

void RowStream::NodeBlocks::advance() {
  while (const auto event = reader_.next()) {
    clock_.take(*event);
    if (event->channel != scans_ || accept(*event, sealed_) != Refusal::kNone ||
        sealed_.kind != BlockKind::kScan || sealed_.header.node != part_.node ||
        sealed_.header.epoch != part_.epoch)
      continue;
    bool placed = false;
    in_sequence_.add(sealed_, [&](const SealedBlock&) { placed = true; });
    if (placed) return place();
  }
  there_ = false;
}

RowStream::RowStream(const std::filesystem::path& folder, const ExportTable& table, std::size_t group)
    : table_(table), group_(table.group[group]), nodes_(0), last_ns_(kUnknownTime) {
  std::set<std::int32_t> nodes;
  for (const auto& part : group_.part) {
    if (part.column.empty()) continue;
    nodes.insert(part.node);
    part_.push_back(std::make_unique<NodeBlocks>(folder, part, table.own_clocks));
  }
  nodes_ = std::ssize(nodes);
}

RowStream::~RowStream() = default;

void RowStream::copy(const NodeBlocks& blocks, std::int64_t row, std::int64_t begin) {
  const ExportPart& part = blocks.part();
  const NodeBlocks::Placed& placed = *blocks.now();
  const auto& from = placed.block.counts[static_cast<std::size_t>(row - placed.first_row)];
  const auto at = static_cast<std::size_t>(row - begin);
  std::int32_t* to = counts_.data() + at * group_.channel.size();
  for (const auto& [converter, column] : part.column)
    if (is_known(placed.block, converter)) to[column] = from[converter];
  if (group_.shared_time) return;
  if (const auto time_ns = blocks.time_ns(row)) time_ns_[at] = *time_ns - table_.start_ns;
}

/// Copies rows [begin, end), as they are counted in the recording.  @return how many there were
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

/// Sets the times of rows without a block, and removes steps back: fits of a clock differ by microseconds.
void RowStream::fill_times(std::int64_t begin) {
  const auto step_ns = static_cast<std::int64_t>(std::llround(1e9 / group_.rate_hz));
  for (std::size_t k = 0; k < time_ns_.size(); ++k) {
    const std::int64_t row = begin + static_cast<std::int64_t>(k);
    std::int64_t& time_ns = time_ns_[k];
    if (group_.shared_time)
      time_ns = time_after_ns(group_.origin_ns, row, group_.period_ps) - table_.start_ns;
    else if (time_ns == kUnknownTime)
      time_ns = last_ns_ == kUnknownTime ? group_.first_ns : last_ns_ + step_ns;
    if (last_ns_ != kUnknownTime) time_ns = std::max(time_ns, last_ns_ + 1);
    last_ns_ = time_ns;
  }
}

ExportRows RowStream::next() {
  const std::int64_t rows = std::min(kRows, group_.rows - row_);
  if (rows <= 0) return {};
  const auto count = static_cast<std::size_t>(rows);
  counts_.assign(count * group_.channel.size(), kMissingCounts);
  time_ns_.assign(count, kUnknownTime);
  const std::int64_t begin = group_.first_row + row_;
  missing_ += nodes_ * rows;
  for (const auto& part : part_) missing_ -= fill(*part, begin, begin + rows);
  fill_times(begin);
  const ExportRows given{.first_row = row_, .time_ns = time_ns_, .counts = counts_};
  row_ += rows;
  return given;
}

}  // namespace roadbalance
