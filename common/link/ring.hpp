#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/types/block.hpp"

namespace roadbalance {

/// The node's memory: sealed blocks by sequence number, from the producer's commit until the consumer frees
/// them.  One producer thread, one consumer thread, no locks.  All memory is taken at construction.
///
/// Sequence numbers start at 1 and the block `sequence` lies in slot sequence % capacity.
class Ring {
 public:
  static constexpr std::size_t kDefaultBytes = std::size_t{16} << 20;  ///< the transputer's memory

  /// @param bytes  at least 16 blocks' worth  @throws std::invalid_argument if it is less
  explicit Ring(std::size_t bytes = kDefaultBytes);

  std::int64_t capacity() const { return static_cast<std::int64_t>(slots_.size()); }
  std::int64_t base() const { return base_.load(std::memory_order_acquire); }  ///< oldest sequence held
  std::int64_t next() const { return next_.load(std::memory_order_acquire); }  ///< sequence of the next block
  std::int64_t used() const;                                                   ///< blocks held, by any thread

  /// Producer: room for block number next(), or nullptr if the ring is full.  Its old content is meaningless.
  SealedBlock* claim();
  /// Producer: the block given by claim() is sealed; its header.sequence is next().
  void commit();

  /// Consumer: base() <= sequence < next().
  const SealedBlock& get(std::int64_t sequence) const;
  /// Consumer: everything through `sequence` < next() is given back; lower than base() does nothing.
  void free_through(std::int64_t sequence);

 private:
  std::vector<SealedBlock> slots_;
  // On cache lines of their own: each is written by one thread and read by the other all the time.
  alignas(64) std::atomic<std::int64_t> next_{1};
  alignas(64) std::atomic<std::int64_t> base_{1};
};

}  // namespace roadbalance
