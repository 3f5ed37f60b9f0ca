#include "common/dsp/state_filter.hpp"

#include <utility>

namespace roadbalance {

StateFilter::StateFilter(DiscreteFilter filter, Eigen::Index channels)
    : filter_(std::move(filter)),
      x_(Eigen::ArrayXXd::Zero(channels, filter_.b0.size())),
      next_(x_),
      last_(Eigen::ArrayXd::Zero(channels)) {}

const Eigen::ArrayXXd& StateFilter::update(const Eigen::Ref<const Eigen::ArrayXd>& u) {
  for (Eigen::Index i = 0; i < x_.cols(); ++i) {
    next_.col(i) = filter_.b0(i) * last_ + filter_.b1(i) * u;
    for (Eigen::Index j = 0; j < x_.cols(); ++j) next_.col(i) += filter_.A(i, j) * x_.col(j);
  }
  x_.swap(next_);
  last_ = u;
  return x_;
}

void StateFilter::reset() {
  x_.setZero();
  last_.setZero();
}

}  // namespace roadbalance
