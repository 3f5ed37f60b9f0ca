#include "common/record/record_state.hpp"

#include <algorithm>
#include <utility>

#include "common/bus/codec.hpp"
#include "common/record/folder.hpp"
#include "common/record/record.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"

namespace roadbalance {
namespace {

bool is_vehicle_part(const SealedBlock& block) {
  return block.kind == BlockKind::kMeta && block.header.node > 0 &&
         decode_meta(block).kind == MetaKind::kVehicleToml;
}

// Every segment repeats it.
void add_vehicle_part(const SealedBlock& block, std::vector<SealedBlock>& parts) {
  const std::int32_t part = decode_meta(block).part;
  if (std::none_of(parts.begin(), parts.end(),
                   [part](const SealedBlock& known) { return decode_meta(known).part == part; }))
    parts.push_back(block);
}

}  // namespace

void add(const SealedBlock& block, RecordState& state) {
  const NodeEpoch key{block.header.node, block.header.epoch};
  if (is_vehicle_part(block)) add_vehicle_part(block, state.vehicle[key]);
  if (block.header.sequence <= 0) return;
  RecordState::Epoch& epoch = state.epoch[key];
  EpochPosition& position = epoch.position;
  const bool is_gap = block.kind == BlockKind::kGap;
  const GapCause cause = is_gap ? decode_gap(block).cause : GapCause::kRingFull;
  const bool covers_those_before = is_gap && stands_for_lost_blocks(cause);
  if (block.header.sequence <= position.contiguous) return;
  if (block.header.sequence != position.contiguous + 1 && !covers_those_before) return;
  position.contiguous = block.header.sequence;
  ++epoch.blocks;
  epoch.gaps += is_gap ? 1 : 0;
  epoch.samples += block.kind == BlockKind::kScan ? block.header.scans : 0;
  if (is_gap && cause == GapCause::kNodeCrash) position.crashed = true;
  if (block.kind == BlockKind::kEnd || position.crashed) position.ended = true;
  if (block.kind == BlockKind::kScan || is_gap)
    position.next_scan = block.header.first_scan + block.header.scans;
}

void read_segments(const std::filesystem::path& folder, int first, RecordState& state,
                   const AtSegmentEnd& at_end, Disk& disk) {
  RecordReader reader(folder, disk, first);
  reader.finish();
  int segment = reader.segment();
  SealedBlock block;
  while (const auto event = reader.next()) {
    if (reader.segment() != segment) at_end(std::exchange(segment, reader.segment()), state);
    if (accept(event->data, block) == Refusal::kNone) add(block, state);
  }
  at_end(segment, state);
}

RecordState read_state(const std::filesystem::path& folder, Disk& disk, RecordState before) {
  if (!is_folder(folder, disk)) return before;
  const auto numbers = segment_numbers(folder, disk);
  if (numbers.empty()) return before;
  int first = numbers.front();
  for (auto number = numbers.rbegin(); number != numbers.rend(); ++number)
    if (const auto index = read_index(folder, *number, disk)) {
      for (const auto& [key, epoch] : index->epoch) before.epoch[key] = epoch;
      first = *number + 1;
      break;
    }
  // The descriptions stand at the beginning of every segment, of the last one at least.
  read_segments(
      folder, std::min(first, numbers.back()), before, [](int, const RecordState&) {}, disk);
  return before;
}

}  // namespace roadbalance
