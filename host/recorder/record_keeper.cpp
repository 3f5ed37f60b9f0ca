#include "host/recorder/record_keeper.hpp"

#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "host/recorder/manifest.hpp"
#include "host/recorder/preamble.hpp"

namespace roadbalance {

RecordKeeper::RecordKeeper(Disk& disk, KeeperOptions options)
    : disk_(disk),
      options_(std::move(options)),
      writer_({.folder = options_.folder, .segment_bytes = options_.segment_bytes}, disk),
      recovered_(recover_record(options_.folder, disk)),
      vehicle_(recovered_.vehicle) {
  writer_.set_preamble(make_preamble(vehicle_));
}

void RecordKeeper::set_clocks(std::int64_t utc_us, std::int64_t host_ns) {
  utc_us_ = utc_us;
  host_ns_ = host_ns;
}

void RecordKeeper::append(const Delivery& delivery, WallTime now) {
  SealedBlock declared;
  const auto* block = std::get_if<SealedBlock>(&delivery);
  if (!block) {
    seal(std::get<GapBlock>(delivery), declared);
    block = &declared;
  }
  if (pending_.empty()) oldest_ = now;
  writer_.append(block_channel(block->header.node, block->kind), block->bytes(), utc_us_);
  uncommitted_bytes_ += block->size;
  bytes_recorded_ += block->size;
  ++waiting_blocks_;
  urgent_ = urgent_ || block->kind == BlockKind::kEnd;
  const NodeEpoch key{block->header.node, block->header.epoch};
  pending_[key] = block->header.sequence;
  if (block->kind == BlockKind::kMeta && decode_meta(*block).kind == MetaKind::kVehicleToml) {
    vehicle_[key].push_back(*block);
    writer_.set_preamble(make_preamble(vehicle_));
  }
}

bool RecordKeeper::commit_is_due(WallTime now) const {
  return !pending_.empty() &&
         (urgent_ || uncommitted_bytes_ >= options_.commit_bytes || time_left(now).count() <= 0);
}

std::chrono::milliseconds RecordKeeper::time_left(WallTime now) const {
  if (pending_.empty()) return options_.commit_period;
  return std::chrono::ceil<std::chrono::milliseconds>(oldest_ + options_.commit_period - now);
}

std::vector<DurableMark> RecordKeeper::commit(WallTime) {
  writer_.sync();
  if (writer_.segment() > listed_ + 1) {
    listed_ = writer_.segment() - 1;
    write_manifest(options_.folder, listed_, disk_);
  }
  std::vector<DurableMark> marks;
  for (const auto& [key, sequence] : pending_) marks.push_back({key.first, key.second, sequence});
  pending_.clear();
  uncommitted_bytes_ = 0;
  waiting_blocks_ = 0;
  urgent_ = false;
  return marks;
}

std::vector<DurableMark> RecordKeeper::close(WallTime now) {
  auto marks = commit(now);
  writer_.close();
  write_manifest(options_.folder, std::nullopt, disk_);
  return marks;
}

void RecordKeeper::fill(RecorderStatus& status) const {
  status.state = state();
  status.segment = writer_.segment();
  status.bytes_recorded = bytes_recorded_;
  status.waiting_blocks = waiting_blocks_;
}

}  // namespace roadbalance
