#pragma once

#include <Eigen/Core>

#include "common/dsp/linear_filter.hpp"
#include "common/process/aligned_memory.hpp"

namespace roadbalance {

/// One DiscreteFilter run over many channels at once.  Rows are channels (so that the channels of one
/// state lie side by side and the arithmetic runs across them), columns the filter's states.
class StateFilter {
 public:
  using States = Eigen::Map<const Eigen::ArrayXXd>;

  StateFilter(DiscreteFilter filter, Eigen::Index channels);

  /// Advances one sample.  Never allocates.
  /// @param u  [channels] input at this sample
  /// @return   [channels x order] states at this sample; valid until the next call
  States update(const Eigen::Ref<const Eigen::ArrayXd>& u);

  States states() const { return {x_.data(), std::ssize(last_), filter_.b0.size()}; }

  /// Starts again from rest, with the input before the first sample equal to zero.
  void reset();

 private:
  DiscreteFilter filter_;
  AlignedVector<double> x_, next_;  ///< [channel x state], by columns
  AlignedVector<double> last_;      ///< [channel] input
};

}  // namespace roadbalance
