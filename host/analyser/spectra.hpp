#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/dsp/psd.hpp"
#include "common/link/blocks.hpp"

namespace roadbalance {

/// Welch spectra of one node's accelerations over the last seconds, for display.
class SpectrumMeter {
 public:
  static constexpr double kSegment_s = 2.0;   ///< lines lie half a hertz apart
  static constexpr double kHistory_s = 10.0;  ///< what a spectrum averages over
  static constexpr double kHighest_hz = 250.0;

  explicit SpectrumMeter(const NodeConfig& node);

  /// A block that does not follow the last one begins the history anew: a hole is not a signal.
  void add(const ScanBlock& block);

  /// Spectra of all channels up to kHighest_hz in parts; none before the first segment is full or if no block
  /// came since the last time.
  std::vector<SpectrumPart> take();

 private:
  void append_parts(std::int32_t channel, std::vector<SpectrumPart>& parts) const;

  NodeConfig node_;
  WelchPsd psd_;
  std::size_t segment_;
  std::size_t keep_;
  std::vector<std::vector<double>> history_;  ///< [channel][sample], m/s^2
  std::int64_t epoch_ = 0;
  std::int64_t next_scan_ = 0;
  std::int64_t end_ns_ = 0;
  bool news_ = false;
};

}  // namespace roadbalance
