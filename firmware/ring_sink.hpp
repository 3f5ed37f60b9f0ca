#pragma once

#include "common/link/planted.hpp"
#include "common/link/ring.hpp"
#include "firmware/block_sink.hpp"

namespace roadbalance {

/// The ring as the packer sees it.  Once full it stays closed until a twentieth is free again, so that a ring
/// at its limit gives few long gaps and not many short ones.
class RingSink final : public BlockSink {
 public:
  explicit RingSink(Ring& ring) : ring_(ring) {}

  std::size_t room() const noexcept override {
    return closed() ? 0 : static_cast<std::size_t>(ring_.capacity() - ring_.used());
  }
  SealedBlock* claim() noexcept override {
    if (closed()) return nullptr;
    if (planted(PlantedFault::kOverwriteOldest) && ring_.used() == ring_.capacity())
      ring_.free_through(ring_.base());
    SealedBlock* const block = ring_.claim();
    full_ = block == nullptr;
    return block;
  }
  void commit() noexcept override { ring_.commit(); }

 private:
  bool closed() const noexcept { return full_ && ring_.used() * 20 >= ring_.capacity() * 19; }

  Ring& ring_;
  bool full_ = false;
};

}  // namespace roadbalance
