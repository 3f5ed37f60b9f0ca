#pragma once

#include <cstddef>

#include "common/types/block.hpp"

namespace roadbalance {

/// Where sealed blocks go, in the order of their sequence.
class BlockSink {
 public:
  BlockSink() = default;
  BlockSink(const BlockSink&) = delete;
  BlockSink& operator=(const BlockSink&) = delete;
  virtual ~BlockSink() = default;

  /// Blocks that surely fit now.
  virtual std::size_t room() const noexcept = 0;
  /// A block to seal into, or nullptr if there is no room: then the samples are lost and declared so.
  virtual SealedBlock* claim() noexcept = 0;
  /// The block given by claim() is sealed.
  virtual void commit() noexcept = 0;
};

}  // namespace roadbalance
