#include "host/orders/fewer_samples.hpp"

#include <algorithm>

#include "common/dsp/decimation.hpp"
#include "common/dsp/weighted_sum.hpp"

namespace roadbalance {

FewerSamples::FewerSamples(int channels, int factor, Emit emit)
    : factor_(factor), taps_(decimation_taps(factor)), sum_(channels), emit_(std::move(emit)) {
  history_.resize(channels, 8 * taps_.size());
  beside_.resize(static_cast<std::size_t>(history_.cols()));
}

void FewerSamples::add(const std::optional<double>& angle_rad,
                       const Eigen::Ref<const Eigen::VectorXd>& values, std::uint32_t overload) {
  if (factor_ == 1) return emit_(angle_rad, values, overload);
  const Eigen::Index n = taps_.size();
  if (filled_ == history_.cols()) {
    history_.leftCols(n - 1) = history_.rightCols(n - 1).eval();
    std::copy(beside_.end() - (n - 1), beside_.end(), beside_.begin());
    filled_ = n - 1;
  }
  history_.col(filled_) = values;
  beside_[static_cast<std::size_t>(filled_)] = {angle_rad, overload, lost_};
  if (count_ == 0) lost_ = false;
  ++filled_;
  const bool is_given = filled_ >= n && count_ == 0;  // 8 factor samples after the one that is given
  count_ = (count_ + 1) % factor_;
  if (!is_given) return;
  weighted_sum(history_.middleCols(filled_ - n, n), taps_, sum_);
  std::uint32_t any = 0;
  for (Eigen::Index i = filled_ - n; i < filled_; ++i) any |= beside_[static_cast<std::size_t>(i)].overload;
  const Beside& middle = beside_[static_cast<std::size_t>(filled_ - 1 - (n - 1) / 2)];
  emit_(middle.lost ? std::nullopt : middle.angle_rad, sum_, any);
}

}  // namespace roadbalance
