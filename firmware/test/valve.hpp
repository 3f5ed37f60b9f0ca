#pragma once

#include <vector>

#include "firmware/block_sink.hpp"

namespace roadbalance::test {

/// Takes blocks while it is open; all that was ever committed stays.
class Valve final : public BlockSink {
 public:
  std::size_t room() const noexcept override { return open ? 1000 : 0; }
  SealedBlock* claim() noexcept override { return open ? &next_ : nullptr; }
  void commit() noexcept override { blocks.push_back(next_); }

  bool open = true;
  std::vector<SealedBlock> blocks;

 private:
  SealedBlock next_;
};

}  // namespace roadbalance::test
