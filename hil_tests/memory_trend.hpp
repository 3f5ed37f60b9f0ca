#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>

namespace roadbalance::test {

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
