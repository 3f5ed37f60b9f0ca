#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/types/scan.hpp"

namespace roadbalance {

/// Scans not yet sealed, by position: how many came before them since construction.  Never allocates after
/// construction.
class WaitingScans {
 public:
  explicit WaitingScans(double rate_hz);

  /// False if the scan is refused: numbered before an earlier one, or beyond kIndexLimit.
  bool push(const Scan& scan) noexcept;

  /// Position of the first scan that waits, and of the next one pushed.
  std::int64_t begin() const noexcept { return head_; }
  std::int64_t end() const noexcept { return tail_; }
  const Scan& at(std::int64_t position) const noexcept {
    return scan_[static_cast<std::size_t>(position) % scan_.size()];
  }
  const Scan& front() const noexcept { return at(head_); }
  std::size_t capacity() const noexcept { return scan_.size(); }
  bool is_full() const noexcept { return tail_ - head_ == static_cast<std::int64_t>(scan_.size()); }
  /// Time of the last scan pushed.
  NodeTime latest() const noexcept { return latest_; }

  /// Scans at the front that make one block.
  struct Run {
    int scans = 0;
    bool whole = false;  ///< nothing can be added to it
  };
  /// @param borders  positions that lie between two blocks
  Run next_run(const std::array<std::int64_t, 2>& borders) const noexcept;

  bool any_taken() const noexcept { return taken_index_ >= 0; }
  /// True if the first scan that waits does not follow the last one taken.
  bool after_jump() const noexcept { return !any_taken() || front().index != taken_index_; }
  /// The first `scans`, which follow one another, are sealed.
  void take(int scans) noexcept;

 private:
  std::vector<Scan> scan_;
  std::int64_t head_ = 0, tail_ = 0;
  std::int64_t jumps_ = 0;         ///< index jumps among the waiting scans
  std::int64_t next_index_ = -1;   ///< device index after the last scan pushed
  std::int64_t taken_index_ = -1;  ///< device index after the last scan taken
  NodeTime latest_{};
};

}  // namespace roadbalance
