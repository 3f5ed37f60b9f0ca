#pragma once

#include <array>
#include <optional>
#include <span>

#include "common/link/block.hpp"

namespace roadbalance {

/// What the planted faults kBlockAltered and kBlocksSwapped do to blocks on their way to the disk; in every
/// other build a block is given back as it came.
class AlterBlocks {
 public:
  /// The blocks to write now; valid until the next call, and as long as `block` is.
  std::span<const SealedBlock> operator()(const SealedBlock& block);

 private:
  std::span<const SealedBlock> altered(const SealedBlock& block);
  std::span<const SealedBlock> swapped(const SealedBlock& block);

  std::optional<SealedBlock> held_;
  std::array<SealedBlock, 2> given_;
};

}  // namespace roadbalance
