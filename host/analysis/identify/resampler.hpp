#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/fractional_delay.hpp"
#include "host/analysis/identify/grid.hpp"

namespace roadbalance {

/// Samples of one node at their own instants -> rows on the grid.
///
/// All 16 channels take the same FractionalDelay, references and accelerations alike, so phases within a node
/// stay as they are.  A row is made of the 32 samples around it; where samples are not there, or their
/// instants jump by half a period or more (a gap, a break of the time base), the rows that would need them
/// are left out: 15 periods on either side.  Overload and quality are those of all samples a row was made of.
class Resampler {
 public:
  /// @param position  of the block's first sample on the grid, in periods
  /// @param spacing   of its samples, in periods
  /// @param follows   it goes on from the block before
  /// @param out       rows that are complete now are appended
  void add(const ScanBlock& block, double position, double spacing, bool follows, const Grid& grid,
           std::vector<GridRows>& out);
  /// The next block follows nothing.
  void reset() { filled_ = 0; }

 private:
  static constexpr Eigen::Index kCapacity = 256;
  struct Sample {
    double position;
    std::int32_t overload, quality;
  };
  void push(const ScanBlock& block, std::int64_t row, double position);
  void emit(const Grid& grid, std::vector<GridRows>& out);

  FractionalDelay delay_;
  Eigen::Matrix<double, kChannels, kCapacity> counts_;  ///< [channel x sample], column filled_ - 1 the newest
  std::array<Sample, kCapacity> sample_{};
  Eigen::Index filled_ = 0;
  Eigen::Index at_ = 0;    ///< sample at or before the next row
  std::int64_t next_ = 0;  ///< index of the next row
  bool restart_ = true;    ///< no row came since the last jump
};

}  // namespace roadbalance
