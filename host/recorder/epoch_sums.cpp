#include "host/recorder/epoch_sums.hpp"

#include "common/bus/codec.hpp"

namespace roadbalance {

EpochSums::EpochSums(const RecordState& recovered) {
  for (const auto& [key, epoch] : recovered.epoch)
    sums_[key] = epoch.sum ? std::optional(BlockSum(*epoch.sum)) : std::nullopt;
}

void EpochSums::take(const SealedBlock& block) {
  auto& sum = sums_.try_emplace({block.header.node, block.header.epoch}, BlockSum()).first->second;
  if (block.kind == BlockKind::kGap && is_declared_by_host(decode_gap(block).cause)) sum.reset();
  if (sum && block.kind != BlockKind::kEnd) sum->add(block);
}

std::optional<bool> EpochSums::agrees(const SealedBlock& end) const {
  const auto found = sums_.find({end.header.node, end.header.epoch});
  if (found == sums_.end() || !found->second) return std::nullopt;
  return decode_end(end).blocks_crc32c == found->second->crc32c();
}

}  // namespace roadbalance
