#pragma once

#include <cassert>

#include "common/link/spool.hpp"

namespace roadbalance {

/// Stands for a disk that could not be opened: it takes nothing, and that counts as one failure.
class UnopenedSpool final : public Spool {
 public:
  std::int64_t base() const override { return 1; }
  std::int64_t next() const override { return 1; }
  std::int64_t capacity() const override { return 0; }
  std::int64_t failures() const override { return 1; }
  void describe(const SealedBlock&) override {}
  void keep(const Ring&, std::int64_t, std::int64_t, WallTime) override {}
  void never_wait() override {}
  bool read(std::int64_t, SealedBlock&) override {
    assert(false);  // it holds nothing
    return false;
  }
  bool answers() override { return false; }
  void free_through(std::int64_t) override {}
  void give_up_through(std::int64_t) override {}
};

}  // namespace roadbalance
