#pragma once

#include <Eigen/Core>

#include "common/dsp/linear_filter.hpp"

namespace roadbalance {

/// One DiscreteFilter run over many channels at once.  Rows are channels (so that the channels of one
/// state lie side by side and the arithmetic runs across them), columns the filter's states.
class StateFilter {
 public:
  StateFilter(DiscreteFilter filter, Eigen::Index channels);

  /// Advances one sample.  Never allocates.
  /// @param u  [channels] input at this sample
  /// @return   [channels x order] states at this sample; valid until the next call
  const Eigen::ArrayXXd& update(const Eigen::Ref<const Eigen::ArrayXd>& u);

  const Eigen::ArrayXXd& states() const { return x_; }

  /// Starts again from rest, with the input before the first sample equal to zero.
  void reset();

 private:
  DiscreteFilter filter_;
  Eigen::ArrayXXd x_, next_;
  Eigen::ArrayXd last_;
};

}  // namespace roadbalance
