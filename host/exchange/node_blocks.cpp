#include "host/exchange/node_blocks.hpp"

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"

namespace roadbalance {

NodeBlocks::NodeBlocks(const std::filesystem::path& folder, const ExportPart& part)
    : reader_(folder),
      part_(part),
      scans_(block_channel(part.node, BlockKind::kScan)),
      fits_(clock_fit_channel(part.node)),
      fit_(part.first_fit) {
  reader_.finish();
  advance();
}

void NodeBlocks::place() {
  now_.block = decode_scan(sealed_);
  now_.first_row = part_.first_row + sealed_.header.first_scan - part_.first_scan;
  now_.fit = fit_;
}

void NodeBlocks::advance() {
  while (const auto event = reader_.next()) {
    if (event->channel == fits_) {
      const auto fit = decode_clock_fit(event->data);
      if (fit && fit->node == part_.node && fit->epoch == part_.epoch && fit->state != ClockState::kAcquire)
        fit_ = fit;
    }
    if (event->channel != scans_ || accept(event->data, sealed_) != Refusal::kNone ||
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
