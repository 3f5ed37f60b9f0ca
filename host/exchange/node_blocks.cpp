#include "host/exchange/node_blocks.hpp"

#include <algorithm>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"

namespace roadbalance {

NodeBlocks::NodeBlocks(const std::filesystem::path& folder, const ExportGroup& group, std::int32_t node)
    : reader_(folder),
      group_(group),
      node_(node),
      scans_(block_channel(node, BlockKind::kScan)),
      fits_(clock_fit_channel(node)) {
  reader_.finish();
  advance();
}

bool NodeBlocks::place() {
  const BlockHeader& header = sealed_.header;
  const auto part = std::find_if(group_.part.begin(), group_.part.end(), [&](const ExportPart& p) {
    return p.node == header.node && p.epoch == header.epoch;
  });
  if (part == group_.part.end()) return false;
  now_.block = decode_scan(sealed_);
  now_.part = &*part;
  now_.first_row = part->first_row + header.first_scan - part->first_scan;
  const auto fit = fit_.find(header.epoch);
  now_.fit = fit != fit_.end() ? std::optional(fit->second) : part->first_fit;
  return true;
}

void NodeBlocks::advance() {
  while (const auto event = reader_.next()) {
    if (event->channel == fits_) {
      const auto fit = decode_clock_fit(event->data);
      if (fit && fit->node == node_ && fit->state != ClockState::kAcquire) fit_[fit->epoch] = *fit;
    }
    if (event->channel != scans_ || accept(event->data, sealed_) != Refusal::kNone ||
        sealed_.kind != BlockKind::kScan)
      continue;
    bool placed = false;
    in_sequence_.add(sealed_, [&](const SealedBlock&) { placed = place(); });
    if (placed) return;
  }
  there_ = false;
}

}  // namespace roadbalance
