#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "firmware/block_sink.hpp"

namespace roadbalance::test {

/// Takes blocks while it is open and has places; all that was ever committed stays.
class Valve final : public BlockSink {
 public:
  std::size_t room() const noexcept override { return open ? places : 0; }
  SealedBlock* claim() noexcept override { return room() > 0 ? &next_ : nullptr; }
  void commit() noexcept override {
    blocks.push_back(next_);
    --places;
  }

  bool open = true;
  std::size_t places = std::numeric_limits<std::size_t>::max();
  std::vector<SealedBlock> blocks;

 private:
  SealedBlock next_;
};

}  // namespace roadbalance::test
