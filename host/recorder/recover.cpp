#include "host/recorder/recover.hpp"

#include <algorithm>

#include "common/bus/codec.hpp"
#include "common/record/folder.hpp"
#include "common/record/record.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {
namespace {

bool covers_sequences_before(const SealedBlock& block) {
  return block.kind == BlockKind::kGap && stands_for_lost_blocks(decode_gap(block).cause);
}

bool is_crash(const SealedBlock& block) {
  return block.kind == BlockKind::kGap && decode_gap(block).cause == GapCause::kNodeCrash;
}

void add(const SealedBlock& block, Recovered& recovered) {
  const NodeEpoch key{block.header.node, block.header.epoch};
  auto& epoch = recovered.epoch[key];
  if (block.header.sequence <= epoch.position.contiguous) return;
  if (block.header.sequence != epoch.position.contiguous + 1 && !covers_sequences_before(block)) return;
  epoch.position.contiguous = block.header.sequence;
  ++epoch.blocks;
  epoch.gaps += block.kind == BlockKind::kGap ? 1 : 0;
  epoch.samples += block.kind == BlockKind::kScan ? block.header.scans : 0;
  if (block.kind == BlockKind::kEnd || is_crash(block)) epoch.position.ended = true;
  if (block.kind == BlockKind::kScan || block.kind == BlockKind::kGap)
    epoch.position.next_scan = block.header.first_scan + block.header.scans;
  if (block.kind == BlockKind::kMeta && decode_meta(block).kind == MetaKind::kVehicleToml)
    recovered.vehicle[key].push_back(block);
}

}  // namespace

Recovered recover_record(const std::filesystem::path& folder, Disk& disk) {
  Recovered recovered;
  if (!is_folder(folder, disk) || segment_numbers(folder, disk).empty()) return recovered;
  RecordReader reader(folder, disk);
  reader.finish();
  SealedBlock block;
  while (const auto event = reader.next())
    if (accept(event->data, block) == Refusal::kNone && block.header.sequence > 0) add(block, recovered);
  return recovered;
}

}  // namespace roadbalance
