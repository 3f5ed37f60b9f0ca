#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

#include "common/types/blocks.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// Gives the instants of a node's samples at which results on them are to be sent.
///
/// Beats stand in the samples, one each interval from the epoch's first scan on: the results of a drive are
/// of the same samples when it is played again, whatever the wall clock did.  Beats are left out where
/// samples come much faster than they were taken: results are then of a longer time.
class SampleBeat {
 public:
  explicit SampleBeat(double interval_s) : interval_s_(interval_s) {}

  /// @param block  the newest, which is among the samples of the result
  bool due(const ScanBlock& block, WallTime now) {
    const double scans = interval_s_ * 1e12 / static_cast<double>(block.period_ps);
    const std::int64_t each = std::max<std::int64_t>(1, std::llround(scans));
    if (block.header.epoch != epoch_) {
      epoch_ = block.header.epoch;
      beat_ = block.header.first_scan / each;
    }
    const std::int64_t beat = (block.header.first_scan + block.header.scans) / each;
    if (beat == beat_) return false;
    beat_ = beat;
    const double waited_s = std::chrono::duration<double>(now - earned_).count();
    earned_ = now;
    credit_ = std::min(kBurst, credit_ + kMostOften * waited_s / interval_s_);
    if (credit_ < 1.0) return false;
    credit_ -= 1.0;
    return true;
  }

 private:
  /// Beats in an interval of the wall clock: more than one, so that samples that were kept for a while are
  /// used in full.
  static constexpr double kMostOften = 1.5;
  static constexpr double kBurst = 20.0;

  const double interval_s_;
  std::int64_t epoch_ = 0;
  std::int64_t beat_ = 0;
  WallTime earned_{};
  double credit_ = kBurst;
};

}  // namespace roadbalance
