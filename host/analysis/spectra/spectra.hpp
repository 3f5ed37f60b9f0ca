#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/dsp/psd.hpp"
#include "common/types/blocks.hpp"

namespace roadbalance {

/// Welch spectra of one node's accelerations over the last seconds, for display: the mean of the newest
/// segments, each of which is transformed once.  They begin at multiples of half their length, rounded down,
/// counted from the epoch's first scan.
class SpectrumMeter {
 public:
  static constexpr double kSegment_s = 2.0;   ///< lines lie half a hertz apart
  static constexpr double kHistory_s = 10.0;  ///< what a spectrum averages over
  static constexpr double kHighest_hz = 250.0;

  explicit SpectrumMeter(const NodeConfig& node);

  /// A block that does not follow the last one begins anew: a hole is not a signal.
  void add(const ScanBlock& block);

  /// Spectra of all channels up to kHighest_hz in parts; none if no segment has become full since the last
  /// time.
  std::vector<SpectrumPart> take();

 private:
  void take_rows(const ScanBlock& block, std::int64_t first, std::int64_t count);
  void add_segment();
  void append_parts(std::int32_t channel, std::vector<SpectrumPart>& parts) const;

  NodeConfig node_;
  WelchPsd psd_;  ///< of one segment at a time
  std::int64_t segment_, hop_;
  std::size_t bins_;  ///< up to kHighest_hz
  /// [channel][sample] of the segment that is being filled: half as long as in m/s^2, for no near cache holds
  /// those of all nodes.
  std::vector<std::vector<std::int32_t>> counts_;
  std::vector<double> samples_;  ///< m/s^2, of one channel's segment
  std::int64_t filled_ = 0;
  std::deque<std::vector<double>> densities_;  ///< [segment][channel, bin], the newest last
  std::int64_t epoch_ = 0;
  std::int64_t next_scan_ = 0;
  std::int64_t end_ns_ = 0;  ///< of the newest segment
  bool news_ = false;
};

}  // namespace roadbalance
