#include "common/record/record_state.hpp"

#include <algorithm>
#include <utility>

#include "common/bus/codec.hpp"
#include "common/record/folder.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_extent.hpp"
#include "common/record/segment_index.hpp"

namespace roadbalance {
namespace {

bool is_vehicle_part(const SealedBlock& block) {
  return block.kind == BlockKind::kMeta && block.header.node > 0 &&
         decode_meta(block).kind == MetaKind::kVehicleToml;
}

bool has_ended(const NodeEpoch& key, const RecordState& state) {
  const auto epoch = state.epoch.find(key);
  return epoch != state.epoch.end() && epoch->second.position.ended;
}

// Those that have ended go first.
bool has_room(RecordState& state) {
  const auto is_there = [&state] {
    std::size_t parts = 0;
    for (const auto& [key, blocks] : state.vehicle) parts += blocks.size();
    return parts < kMostDescriptionPartsInAll;
  };
  if (is_there()) return true;
  std::erase_if(state.vehicle, [&state](const auto& known) { return has_ended(known.first, state); });
  return is_there();
}

// Every segment repeats it.
void add_vehicle_part(const SealedBlock& block, RecordState& state) {
  const NodeEpoch key{block.header.node, block.header.epoch};
  const MetaBlock meta = decode_meta(block);
  if (has_ended(key, state) || meta.parts > kMostDescriptionParts) return;
  if (const auto known = state.vehicle.find(key); known != state.vehicle.end())
    for (const SealedBlock& part : known->second)
      if (decode_meta(part).part == meta.part) return;
  if (has_room(state)) state.vehicle[key].push_back(block);
}

// Each block with its event, and the end of each segment; the clocks on the way, as the first segment holds
// them: a reader that has older fits would take the stretch between for a hole.
template <typename AtBlock, typename AtEnd>
void read_events(const std::filesystem::path& folder, int first, RecordedClocks& clocks, AtBlock&& at_block,
                 AtEnd&& at_end, Disk& disk) {
  clocks = {};
  RecordReader reader(folder, disk, first);
  reader.finish();
  int segment = reader.segment();
  SealedBlock block;
  while (const auto event = reader.next()) {
    if (reader.segment() != segment) at_end(std::exchange(segment, reader.segment()));
    if (accept(*event, block) == Refusal::kNone)
      at_block(reader, *event, block);
    else
      static_cast<void>(clocks.take(event->channel, event->data));
  }
  at_end(segment);
}

}  // namespace

void add(const SealedBlock& block, RecordState& state) {
  const NodeEpoch key{block.header.node, block.header.epoch};
  if (is_vehicle_part(block)) add_vehicle_part(block, state);
  if (block.header.sequence <= 0) return;
  RecordState::Epoch& epoch = state.epoch[key];
  EpochPosition& position = epoch.position;
  const bool is_gap = block.kind == BlockKind::kGap;
  const GapCause cause = is_gap ? decode_gap(block).cause : GapCause::kRingFull;
  const bool covers_those_before = is_gap && stands_for_lost_blocks(cause);
  if (block.header.sequence <= position.contiguous) return;
  const bool has_hole = block.header.sequence != position.contiguous + 1 && !covers_those_before;
  position.contiguous = block.header.sequence;
  if (has_hole || (is_gap && is_declared_by_host(cause))) epoch.sum.reset();
  if (epoch.sum && block.kind != BlockKind::kEnd) {
    BlockSum sum(*epoch.sum);
    sum.add(block);
    epoch.sum = sum.crc32c();
  }
  if (block.kind == BlockKind::kEnd && epoch.sum != decode_end(block).blocks_crc32c) epoch.sum.reset();
  ++epoch.blocks;
  epoch.gaps += is_gap ? 1 : 0;
  epoch.samples += block.kind == BlockKind::kScan ? block.header.scans : 0;
  if (is_gap && cause == GapCause::kNodeCrash) position.crashed = true;
  if (block.kind == BlockKind::kEnd || position.crashed) position.ended = true;
  if (block.kind == BlockKind::kScan || is_gap)
    position.next_scan = block.header.first_scan + block.header.scans;
}

RecordEvents clocks_going_on(const RecordState& state) {
  return state.clocks.events([&state](const NodeEpoch& key) { return !has_ended(key, state); });
}

RecordState::Descriptions going_on(const RecordState& state) {
  RecordState::Descriptions parts = state.vehicle;
  std::erase_if(parts, [&state](const auto& known) { return has_ended(known.first, state); });
  return parts;
}

void read_segments(const std::filesystem::path& folder, int first, RecordState& state,
                   const AtSegmentEnd& at_end, Disk& disk) {
  read_events(
      folder, first, state.clocks,
      [&state](const RecordReader&, const LogEvent&, const SealedBlock& block) { add(block, state); },
      [&](int segment) { at_end(segment, state); }, disk);
}

RecordState read_state(const std::filesystem::path& folder, Disk& disk, RecordState before,
                       std::vector<UnsureBlock>* unsure) {
  if (!is_folder(folder, disk)) return before;
  const auto numbers = segment_numbers(folder, disk);
  if (numbers.empty()) return before;
  const int last = numbers.back();
  const int first = start_from_index(folder, before, disk);
  const bool is_finished = first > last;
  const std::uint64_t durable = is_finished ? 0 : measure_segment(segment_path(folder, last), disk).durable;
  const auto add_or_doubt = [&](const RecordReader& reader, const LogEvent& event, const SealedBlock& block) {
    const bool is_durable = is_finished || reader.segment() != last || reader.offset() < durable;
    // The events that a segment begins with repeat what is durable, and are not written again.
    if (is_durable || block.header.sequence <= 0)
      add(block, before);
    else if (unsure)
      unsure->push_back({.block = block, .timestamp_us = event.timestamp_us});
  };
  // Descriptions and clocks stand at the beginning of every segment, of the last one at least.
  read_events(
      folder, std::min(first, last), before.clocks, add_or_doubt, [](int) {}, disk);
  return before;
}

bool holds_all_of(const RecordState& record, const std::filesystem::path& folder, RecordState before,
                  Disk& disk) {
  std::vector<UnsureBlock> unsure;
  RecordState there = read_state(folder, disk, std::move(before), &unsure);
  for (const UnsureBlock& one : unsure) add(one.block, there);
  return std::ranges::all_of(record.epoch, [&there](const auto& written) {
    const auto found = there.epoch.find(written.first);
    return found != there.epoch.end() && found->second.blocks >= written.second.blocks &&
           found->second.position.contiguous >= written.second.position.contiguous;
  });
}

}  // namespace roadbalance
