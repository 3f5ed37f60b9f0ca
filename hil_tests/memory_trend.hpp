#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>

#include "common/link/epoch_receiver.hpp"

namespace roadbalance::test {

/// What a recorder may have of a node in memory at a time, by the credit it gives: blocks that came out of
/// order and blocks not yet on the disk.  How much of it is ever used depends on how busy the computer is.
inline constexpr double kCredit_mib =
    static_cast<double>(ReceiverOptions{}.window + ReceiverOptions{}.undurable) * sizeof(SealedBlock) /
    (1 << 20);

/// Bytes of its own (anonymous, resident: heap and stacks) that a living program has in memory; nothing once
/// it is gone.
std::optional<std::int64_t> own_memory_bytes(pid_t pid);

/// How a program's memory behaves after its start: what it has when it has settled, and the most it has
/// later.
class MemoryTrend {
 public:
  /// @param settled_after_s  everything before is its start
  explicit MemoryTrend(double settled_after_s) : settled_after_s_(settled_after_s) {}

  void add(double time_s, std::int64_t bytes);
  bool has_settled() const { return settled_.has_value(); }
  std::int64_t settled_bytes() const { return settled_.value_or(0); }
  std::int64_t growth_bytes() const { return most_ - settled_bytes(); }

 private:
  double settled_after_s_;
  std::optional<std::int64_t> settled_;
  std::int64_t most_ = 0;
};

}  // namespace roadbalance::test
