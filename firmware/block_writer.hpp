#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/types/blocks.hpp"
#include "common/types/clocks.hpp"
#include "firmware/block_sink.hpp"

namespace roadbalance {

/// Numbers the blocks of one epoch without gaps from 1, and seals them into a sink.  The vehicle's
/// description comes first.  Never allocates after construction.
class BlockWriter {
 public:
  BlockWriter(int node, std::int64_t epoch, const std::string& description, BlockSink& sink);

  BlockHeader header(std::int64_t first_scan, std::int64_t scans, std::int64_t time_ns) const noexcept {
    return {node_, epoch_, next_sequence_, first_scan, scans, time_ns};
  }

  /// False if the sink has no room: then the block is not written.
  template <typename Block>
  bool write(Block& block) noexcept {
    SealedBlock* const room = sink_.claim();
    if (!room) return false;
    block.header.sequence = next_sequence_;
    seal(block, *room);
    sum_.add(*room);
    sink_.commit();
    ++next_sequence_;
    return true;
  }

  /// Writes what is left of the description, stamped `now`.  True once all of it is written.
  bool write_description(NodeTime now) noexcept;
  std::size_t description_blocks() const noexcept { return description_.size(); }

  std::int64_t next_sequence() const noexcept { return next_sequence_; }
  /// Over all blocks written so far; see BlockSum.
  std::uint32_t blocks_crc32c() const noexcept { return sum_.crc32c(); }

 private:
  const int node_;
  const std::int64_t epoch_;
  BlockSink& sink_;
  std::vector<MetaBlock> description_;
  std::size_t parts_written_ = 0;
  std::int64_t next_sequence_ = 1;
  BlockSum sum_;  ///< of all blocks before next_sequence_
};

}  // namespace roadbalance
