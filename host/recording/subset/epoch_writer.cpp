#include "host/recording/subset/epoch_writer.hpp"

#include <utility>

#include "common/bus/codec.hpp"
#include "common/types/bounded_time.hpp"

namespace roadbalance {

EpochWriter::EpochWriter(NodeEpoch key, const std::string& vehicle_toml, Put put)
    : key_(std::move(key)), put_(std::move(put)) {
  for (MetaBlock& part : split_text(MetaKind::kVehicleToml, vehicle_toml)) write(part, 0, 0);
}

template <typename Block>
void EpochWriter::write(Block& block, std::int64_t scans, std::int64_t time_ns) {
  block.header = {key_.first, key_.second, next_sequence_++, next_scan_, scans, time_ns};
  seal(block, sealed_);
  sum_.add(sealed_);
  put_(sealed_);
  next_scan_ += scans;
}

void EpochWriter::scans(const ScanBlock& block) {
  ScanBlock written = block;
  // A cut before this block is no loss, and a block in the middle of a run follows none.
  written.quality &= ~kQualityAfterGap;
  if (std::exchange(after_gap_, false)) written.quality |= kQualityAfterGap;
  period_ps_ = block.period_ps;
  end_ns_ = time_after_ns(block.header.time_ns, block.header.scans, period_ps_);
  sealed_scans_ += block.header.scans;
  write(written, block.header.scans, block.header.time_ns);
}

void EpochWriter::gap(std::int64_t scans, std::int64_t time_ns, GapCause cause) {
  GapBlock gap;
  gap.cause = cause;
  after_gap_ = after_gap_ || scans > 0;
  missing_scans_ += scans;
  end_ns_ = time_after_ns(time_ns, scans, period_ps_);
  write(gap, scans, time_ns);
}

/// Fills one block after the other: items of one original block nearly always fit into one.
template <typename Block, typename Item>
void EpochWriter::write_all(std::span<const Item> items) {
  Block block;
  const auto put = [&] {
    if (!block.empty()) write(block, 0, block.header.time_ns);
    block = Block{};
  };
  for (const Item& item : items) {
    if (block.add(item)) continue;
    put();
    block.add(item);
  }
  put();
}

void EpochWriter::edges(std::span<const Edge> edges) {
  write_all<EdgeBlock>(edges);
}

void EpochWriter::signals(std::span<const SignalSample> samples) {
  write_all<SignalBlock>(samples);
}

void EpochWriter::end(Ending ending) {
  if (ending == Ending::kOpen) return;
  if (ending == Ending::kCrash) return gap(0, end_ns_, GapCause::kNodeCrash);
  EndBlock end;
  end.blocks = next_sequence_;
  end.scans_sealed = sealed_scans_;
  end.scans_missing = missing_scans_;
  end.blocks_crc32c = sum_.crc32c();
  write(end, 0, end_ns_);
}

}  // namespace roadbalance
