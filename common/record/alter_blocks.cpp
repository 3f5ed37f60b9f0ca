#include "common/record/alter_blocks.hpp"

#include <utility>

#include "common/bus/codec.hpp"
#include "common/link/planted.hpp"

namespace roadbalance {
namespace {

// One block in so many is hit.
constexpr std::int64_t kOneIn = 97;

bool is_hit(const SealedBlock& block) {
  return block.kind == BlockKind::kScan && block.header.sequence % kOneIn == 0;
}

bool is_next(const SealedBlock& first, const SealedBlock& second) {
  return second.kind == BlockKind::kScan && second.header.node == first.header.node &&
         second.header.epoch == first.header.epoch && second.header.sequence == first.header.sequence + 1 &&
         second.header.scans == first.header.scans;
}

}  // namespace

std::span<const SealedBlock> AlterBlocks::operator()(const SealedBlock& block) {
  if (planted(PlantedFault::kBlockAltered)) return altered(block);
  if (planted(PlantedFault::kBlocksSwapped)) return swapped(block);
  return {&block, 1};
}

std::span<const SealedBlock> AlterBlocks::altered(const SealedBlock& block) {
  if (!is_hit(block)) return {&block, 1};
  ScanBlock scans = decode_scan(block);
  scans.counts[0][0] ^= 1;
  seal(scans, given_[0]);
  return {given_.data(), 1};
}

std::span<const SealedBlock> AlterBlocks::swapped(const SealedBlock& block) {
  if (!held_) {
    if (!is_hit(block)) return {&block, 1};
    held_ = block;
    return {};
  }
  given_ = {*held_, block};
  if (is_next(*held_, block)) {
    ScanBlock first = decode_scan(block);
    ScanBlock second = decode_scan(*held_);
    std::swap(first.header, second.header);
    seal(first, given_[0]);
    seal(second, given_[1]);
  }
  held_.reset();
  return given_;
}

}  // namespace roadbalance
