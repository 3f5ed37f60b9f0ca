#pragma once

#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "common/process/aligned_memory.hpp"

namespace roadbalance {

/// A low-pass of which every factor-th output is taken, of all channels at once.
///
/// Each sample is added, times a tap each, to the few outputs that it is part of, and is not kept: the sums
/// stay in the nearest cache.  The same bits on every processor.
class DecimatingFilter {
 public:
  /// The first sample has index 0.
  /// @param factor  >= 1
  /// @param taps    at least one
  DecimatingFilter(Eigen::Index channels, int factor, const Eigen::VectorXd& taps);

  /// Forgets all samples.
  /// @param index  of the next one; there is output at multiples of the factor
  void restart(std::int64_t index);
  /// @param values  [channel]
  /// @return  whether there is output: of this sample and all before it that have taps, none of them
  /// forgotten
  bool add(const Eigen::Ref<const Eigen::VectorXd>& values);
  /// [channel], of the latest sample with output.
  const Eigen::VectorXd& output() const { return output_; }

 private:
  void spread();

  Eigen::Index taps_;
  Eigen::MatrixXd weight_;         ///< [output, the next one first x place]
  std::size_t stride_;             ///< from one sample, or output, to the next: lines of the cache
  AlignedVector<double> waiting_;  ///< [sample][channel], not yet in the sums
  std::size_t samples_ = 0;        ///< of these
  AlignedVector<double> sums_;     ///< [output, in a ring][channel]
  Eigen::VectorXd output_;         ///< [channel]
  std::size_t next_ = 0;           ///< of sums_, the next output
  Eigen::Index place_ = 0;         ///< of the next sample: samples since the last output
  Eigen::Index known_ = 0;         ///< samples that are not forgotten, up to the number of taps
};

}  // namespace roadbalance
