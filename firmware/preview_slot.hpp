#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "common/types/block.hpp"

namespace roadbalance {

/// The latest preview block, from one writer to one reader, which may miss some.  Never waits (triple
/// buffer).
class PreviewSlot {
 public:
  /// Writer: the block to seal into, then publish().
  SealedBlock& writable() noexcept { return block_[write_]; }
  void publish() noexcept {
    write_ = middle_.exchange(static_cast<std::uint8_t>(write_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }

  /// Reader: the latest block if it was not read before, else nullptr.  Valid until the next call.
  const SealedBlock* read() noexcept {
    if (!(middle_.load(std::memory_order_relaxed) & kFresh)) return nullptr;
    read_ = middle_.exchange(read_, std::memory_order_acq_rel) & kIndex;
    return &block_[read_];
  }

 private:
  static constexpr std::uint8_t kFresh = 4, kIndex = 3;
  std::array<SealedBlock, 3> block_;
  std::uint8_t write_ = 0, read_ = 1;
  std::atomic<std::uint8_t> middle_{2};
};

}  // namespace roadbalance
