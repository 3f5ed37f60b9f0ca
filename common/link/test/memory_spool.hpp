#pragma once

#include <deque>
#include <vector>

#include "common/link/spool.hpp"

namespace roadbalance::test {

/// A spool that refuses and forgets as told.
class MemorySpool final : public Spool {
 public:
  std::int64_t base() const override { return base_; }
  std::int64_t next() const override { return base_ + static_cast<std::int64_t>(blocks_.size()); }
  std::int64_t capacity() const override { return room; }
  std::int64_t failures() const override { return failures_; }
  void describe(const SealedBlock& meta) override { described.push_back(meta.header.sequence); }
  void keep(const Ring& ring, std::int64_t first, std::int64_t last, WallTime) override {
    if (last - first >= most_at_once) {
      ++failures_;
      return;
    }
    if (blocks_.empty()) base_ = first;
    for (std::int64_t k = first; k <= last && static_cast<std::int64_t>(blocks_.size()) < room; ++k)
      blocks_.push_back(ring.get(k));
  }
  void never_wait() override {}
  bool read(std::int64_t sequence, SealedBlock& out) override {
    if (sequence == unreadable || all_unreadable) return false;
    out = blocks_.at(static_cast<std::size_t>(sequence - base_));
    return true;
  }
  bool answers() override { return !all_unreadable || answers_all_the_same; }
  void free_through(std::int64_t sequence) override {
    for (; base_ <= sequence; ++base_) blocks_.pop_front();
  }
  void give_up_through(std::int64_t sequence) override { free_through(sequence); }

  std::int64_t room = 1000;
  std::int64_t most_at_once = 1000;  // of more it takes none
  std::int64_t unreadable = 0;
  bool all_unreadable = false;
  bool answers_all_the_same = false;
  std::vector<std::int64_t> described;

 private:
  std::int64_t failures_ = 0;
  std::int64_t base_ = 1;
  std::deque<SealedBlock> blocks_;
};

}  // namespace roadbalance::test
