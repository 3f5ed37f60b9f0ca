#pragma once

#include <chrono>
#include <optional>

#include "common/types/clocks.hpp"

namespace roadbalance {

/// Whether what a board sends in a run brings scans.  One whose converter stands still goes on sending, and
/// so does one of whose packets none can be used.  By the instants of arrival: a node that fetches late
/// what has come does not take the board for dry.
class ScanFlow {
 public:
  /// A running board gives a hundred times as many.
  static constexpr NodeClock::duration kLongestDrought = std::chrono::seconds(1);

  /// One behind a pause of the node is none: a board without a converter sends ten a second.
  static constexpr int kTransfersInVain = 3;

  void start_run() noexcept { *this = ScanFlow(); }

  /// A transfer came.
  /// @param has_scans  that can be used
  /// @param is_seen    all since the last call were
  void take(NodeTime arrival, bool has_scans, bool is_seen) noexcept {
    flows_ = flows_ || has_scans;
    in_vain_ = has_scans || !is_seen ? 0 : in_vain_ + 1;
    if (in_vain_ == 0 || !since_) since_ = arrival;
    is_dry_ = in_vain_ >= kTransfersInVain && arrival - *since_ > kLongestDrought;
  }

  /// Scans have come in this run.
  bool flows() const noexcept { return flows_; }
  /// For too long transfers have come, but no scan.
  bool is_dry() const noexcept { return is_dry_; }

 private:
  std::optional<NodeTime>
      since_;        ///< arrival of the last scan, of the run's first transfer, or of what was lost
  int in_vain_ = 0;  ///< transfers since
  bool flows_ = false;
  bool is_dry_ = false;
};

}  // namespace roadbalance
