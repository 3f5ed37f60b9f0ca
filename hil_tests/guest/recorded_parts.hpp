#pragma once

#include <filesystem>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/record/record_reader.hpp"
#include "firmware/backends/replay/recorded_drive.hpp"

namespace roadbalance::test {

/// Contents of a finished recording of one node, as they were sealed.
inline std::vector<ScanBlock> recorded_blocks(const std::filesystem::path& record) {
  std::vector<ScanBlock> blocks;
  RecordReader reader(record);
  reader.finish();
  SealedBlock block;
  while (const auto event = reader.next())
    if (accept(event->data, block) == Refusal::kNone && block.kind == BlockKind::kScan)
      blocks.push_back(decode_scan(block));
  return blocks;
}

/// Its edges and samples of signals, in order.
inline RecordedPiece recorded_events(const std::filesystem::path& record, std::int32_t node) {
  RecordedPiece all;
  RecordedDrive drive(record, node, {});
  while (const auto piece = drive.next()) {
    all.edges.insert(all.edges.end(), piece->edges.begin(), piece->edges.end());
    all.signals.insert(all.signals.end(), piece->signals.begin(), piece->signals.end());
  }
  return all;
}

}  // namespace roadbalance::test
