#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>

#include "common/bus/tap.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/blocks.hpp"

namespace roadbalance {

/// Tap test: finds taps on a car that stands, which show which channel is which and its sign.
///
/// A tap begins when some acceleration leaves the mean of the last second by kNoises times its rms and by
/// kLeast_m_s2.  The scans within kWindow_s behind it, and the few before, are looked at: a channel's first
/// swing is the first that reaches kSwing of its peak, up to where it crosses the mean.  A filter before
/// conversion makes it later and lower, and leaves its sign.
///
/// Nothing is heard while the wheels turn or anything is louder than kStill_m_s2, and for kQuiet_s after a
/// tap; a hole in the scans begins anew.
class TapMeter {
 public:
  static constexpr double kNoises = 8.0, kLeast_m_s2 = 0.3, kStill_m_s2 = 0.5, kSwing = 0.3;
  static constexpr double kWindow_s = 0.05, kBefore_s = 0.005, kQuiet_s = 0.3, kMemory_s = 1.0;

  explicit TapMeter(const NodeConfig& node);

  /// A tap that has ended in this block.
  std::optional<Tap> add(const ScanBlock& block);

 private:
  using Row = std::array<double, kAccelerations>;  ///< m/s^2
  struct Noise {
    double mean = 0.0, square = 0.0;
  };

  std::optional<Tap> add(const Row& row, std::int64_t time_ns);
  void learn(const Row& row);
  bool begins(const Row& row) const;
  Tap finish() const;
  void begin_anew();

  NodeConfig node_;
  std::array<Noise, kAccelerations> noise_{};
  std::int64_t learned_ = 0;  ///< scans in noise_
  std::int64_t quiet_ = 0;    ///< scans until a tap is heard again
  std::deque<Row> rows_;      ///< about the mean: of the tap, or the last few
  std::int64_t wanted_ = 0;   ///< scans of the tap that are to come
  std::int64_t begin_ns_ = 0;
  std::int64_t number_ = 0;
  std::int64_t next_scan_ = -1;
};

}  // namespace roadbalance
