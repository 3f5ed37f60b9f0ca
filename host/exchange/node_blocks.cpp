#include "host/exchange/node_blocks.hpp"

#include "common/bus/bus.hpp"

namespace roadbalance {

NodeBlocks::NodeBlocks(const std::filesystem::path& folder, const ExportPart& part, bool own_clocks)
    : reader_(folder),
      part_(part),
      scans_(block_channel(part.node, BlockKind::kScan)),
      clock_({part.node, part.epoch}, part.first_fit, own_clocks) {
  reader_.finish();
  advance();
}

void NodeBlocks::place() {
  now_.block = decode_scan(sealed_);
  now_.first_row = part_.first_row + sealed_.header.first_scan - part_.first_scan;
}

void NodeBlocks::advance() {
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

}  // namespace roadbalance
