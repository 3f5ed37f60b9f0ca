#include "host/recording/subset/subset_epoch.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace roadbalance {
namespace {

/// Longer than edges and signals come behind their scans: up to 1.3 s.
constexpr std::int64_t kLatest_ns = 5'000'000'000;

/// Rows [first, first + count) of a block as a block of their own.
ScanBlock rows_of(const ScanBlock& block, std::int64_t first, std::int64_t count) {
  if (count == block.header.scans) return block;
  ScanBlock rows = block;
  rows.counts = {};
  std::copy_n(block.counts.begin() + first, count, rows.counts.begin());
  rows.header.scans = count;
  rows.header.time_ns = block.row_time_ns(first);
  return rows;
}

void keep_channels(std::uint32_t kept, ScanBlock& block) {
  for (auto& row : block.counts)
    for (std::size_t c = 0; c < row.size(); ++c)
      if ((kept >> c & 1) == 0) row[c] = 0;
  block.overload &= static_cast<std::int32_t>(kept);
  if (block.overload == 0) block.quality &= ~kQualityOverload;
}

}  // namespace

SubsetEpoch::SubsetEpoch(const EpochClock& clock, const Pieces& pieces, std::int64_t period_ps,
                         std::uint32_t kept, Begin begin)
    : clock_(clock), pieces_(pieces), period_ps_(period_ps), kept_(kept), begin_(std::move(begin)) {}

EpochSink* SubsetEpoch::sink(std::size_t piece) {
  if (piece < ended_pieces_) return nullptr;
  auto& sink = open_[piece];
  if (!sink) sink = begin_(piece);
  return sink.get();
}

/// Calls run(piece, first, count) for each run of scans in one piece.
template <typename Run>
void SubsetEpoch::by_piece(std::int64_t begin_ns, std::int64_t count, Run&& run) {
  const auto first_from = [&](std::int64_t from, std::int64_t time_ns) {
    for (std::int64_t end = count; from < end;) {
      const std::int64_t middle = from + (end - from) / 2;
      const auto time = time_of(begin_ns, middle);
      (time && *time >= time_ns ? end : from) = time && *time >= time_ns ? middle : middle + 1;
    }
    return from;
  };
  for (std::int64_t k = 0; k < count;) {
    const auto time_ns = time_of(begin_ns, k);
    std::int64_t end = count;
    if (time_ns) {
      const std::size_t piece = piece_from(pieces_, *time_ns);
      at_piece_.reset();
      if (piece == pieces_.size()) return;
      if (*time_ns < pieces_[piece].from_ns) {
        k = first_from(k + 1, pieces_[piece].from_ns);
        continue;
      }
      at_piece_ = piece;
      end = first_from(k + 1, pieces_[piece].to_ns);
    }
    if (at_piece_) run(*at_piece_, k, end - k);
    k = end;
  }
}

void SubsetEpoch::end_older_than(std::int64_t time_ns) {
  while (!open_.empty() && pieces_[open_.begin()->first].to_ns < time_ns) {
    open_.begin()->second->end(EpochSink::Ending::kEnd);
    ended_pieces_ = open_.begin()->first + 1;
    open_.erase(open_.begin());
  }
}

void SubsetEpoch::missing(std::int64_t scans, GapCause cause) {
  const std::int64_t begin_ns = end_ns_;
  by_piece(begin_ns, scans, [&](std::size_t piece, std::int64_t first, std::int64_t count) {
    if (EpochSink* const to = sink(piece)) to->gap(count, after(begin_ns, first), cause);
  });
  next_scan_ += scans;
  end_ns_ = after(begin_ns, scans);
}

/// Declares a hole up to a block whose place is known.
void SubsetEpoch::close_hole(std::int64_t next_scan, std::int64_t time_ns) {
  if (next_scan_ < 0) {
    next_scan_ = next_scan;
    end_ns_ = time_ns;
  }
  const auto cause = std::exchange(lost_, std::nullopt);
  if (next_scan > next_scan_) {
    missing(next_scan - next_scan_, cause.value_or(GapCause::kLostInRecord));
  } else if (cause && at_piece_) {
    if (EpochSink* const to = sink(*at_piece_)) to->gap(0, end_ns_, *cause);
  }
}

void SubsetEpoch::take_scans(ScanBlock block) {
  const std::int64_t overlap = next_scan_ - block.header.first_scan;
  if (overlap >= block.header.scans) return;  // the first copy counts
  if (overlap > 0) block = rows_of(block, overlap, block.header.scans - overlap);
  period_ps_ = block.period_ps;
  if (const auto time_ns = clock_.time_ns(block.header.time_ns); time_ns)
    end_older_than(std::max(*time_ns, std::numeric_limits<std::int64_t>::min() + kLatest_ns) - kLatest_ns);
  if (kept_ != ~0U) keep_channels(kept_, block);
  by_piece(block.header.time_ns, block.header.scans,
           [&](std::size_t piece, std::int64_t first, std::int64_t count) {
             if (EpochSink* const to = sink(piece)) to->scans(rows_of(block, first, count));
           });
  next_scan_ += block.header.scans;
  end_ns_ = after(block.header.time_ns, block.header.scans);
}

void SubsetEpoch::take_gap(const GapBlock& gap) {
  if (gap.cause == GapCause::kNodeCrash) {
    crashed_ = true;
  } else if (gap.header.scans == 0) {
    lost_ = gap.cause;  // blocks that may have held scans, or edges and signals only
  } else {
    close_hole(gap.header.first_scan, gap.header.time_ns);
    const std::int64_t scans = gap.header.first_scan + gap.header.scans - next_scan_;
    if (scans >= 0) missing(scans, gap.cause);  // the first copy counts
  }
}

/// Calls give(sink, run) for each run of items in one piece.
template <typename Item, typename Give>
void SubsetEpoch::items(std::span<const Item> items, Give&& give) {
  const auto piece_of = [&](const Item& item) {
    const auto time_ns = clock_.time_ns(to_ns(item.time));
    return time_ns ? piece_at(pieces_, *time_ns) : at_piece_;
  };
  for (std::size_t first = 0; first < items.size();) {
    const auto piece = piece_of(items[first]);
    std::size_t end = first + 1;
    while (end < items.size() && piece_of(items[end]) == piece) ++end;
    if (EpochSink* const to = piece ? sink(*piece) : nullptr) give(*to, items.subspan(first, end - first));
    first = end;
  }
}

void SubsetEpoch::take(const SealedBlock& block) {
  const BlockHeader& header = block.header;
  const bool declared = block.kind == BlockKind::kGap && stands_for_lost_blocks(decode_gap(block).cause);
  if (header.sequence > last_sequence_ + 1 && last_sequence_ > 0 && !declared && !lost_)
    lost_ = GapCause::kLostInRecord;
  last_sequence_ = header.sequence;
  switch (block.kind) {
    case BlockKind::kScan:
      close_hole(header.first_scan, header.time_ns);
      take_scans(decode_scan(block));
      break;
    case BlockKind::kGap:
      take_gap(decode_gap(block));
      break;
    case BlockKind::kEdge:
      items<Edge>(decode_edge(block).unpack(), [](EpochSink& to, auto run) { to.edges(run); });
      break;
    case BlockKind::kSignal:
      items<SignalSample>(decode_signal(block).unpack(), [](EpochSink& to, auto run) { to.signals(run); });
      break;
    case BlockKind::kEnd:
      close_hole(header.first_scan, header.time_ns);
      ended_ = true;
      break;
    case BlockKind::kMeta:
      break;
  }
  if (const auto time_ns = clock_.time_ns(end_ns_); time_ns && next_scan_ >= 0) reached_ns_ = *time_ns;
}

void SubsetEpoch::finish() {
  if (lost_ && at_piece_)
    if (EpochSink* const to = sink(*at_piece_)) to->gap(0, end_ns_, *lost_);
  for (auto& [piece, to] : open_) {
    using enum EpochSink::Ending;
    const bool is_whole = ended_ || reached_ns_ >= pieces_[piece].to_ns;
    to->end(is_whole ? kEnd : crashed_ ? kCrash : kOpen);
  }
  open_.clear();
}

}  // namespace roadbalance
