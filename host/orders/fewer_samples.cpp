#include "host/orders/fewer_samples.hpp"

#include <algorithm>
#include <utility>

#include "common/dsp/decimation.hpp"
#include "common/dsp/weighted_sum.hpp"

namespace roadbalance {
namespace {

constexpr Eigen::Index kHistory = 3;  // times the taps: as few samples are moved as stay in a near cache
constexpr std::size_t kBehind = 8;  // samples that are given, of which the low-pass knows the later half

}  // namespace

FewerSamples::FewerSamples(int channels, int factor, Emit emit)
    : factor_(factor), taps_(decimation_taps(factor)), sum_(channels), emit_(std::move(emit)) {
  history_.resize(channels, kHistory * taps_.size());
  overload_.resize(static_cast<std::size_t>(history_.cols()));
  follow(1);
}

void FewerSamples::follow(std::size_t angles) {
  next_.resize(angles);
  lost_.resize(angles);
  waiting_.resize((kBehind + 1) * angles);
  interrupt();
}

void FewerSamples::interrupt() {
  filled_ = overloads_end_ = count_ = 0;
  std::ranges::fill(lost_, std::uint8_t{0});
}

void FewerSamples::forget_angles() {
  std::ranges::fill(next_, std::nullopt);
  std::ranges::fill(lost_, std::uint8_t{0});
}

void FewerSamples::remember_angles() {
  const auto wheels = static_cast<std::ptrdiff_t>(next_.size());
  std::copy(waiting_.begin() + wheels, waiting_.end(), waiting_.begin());
  for (std::size_t w = 0; w < next_.size(); ++w)
    waiting_[kBehind * next_.size() + w] = lost_[w] != 0 ? std::nullopt : next_[w];
  forget_angles();
}

void FewerSamples::add(const Eigen::Ref<const Eigen::VectorXd>& values, std::uint32_t overload) {
  if (factor_ == 1) {
    emit_(next_, values, overload);
    return forget_angles();
  }
  const Eigen::Index n = taps_.size();
  if (filled_ == history_.cols()) {
    history_.leftCols(n - 1) = history_.rightCols(n - 1).eval();
    std::copy(overload_.end() - (n - 1), overload_.end(), overload_.begin());
    overloads_end_ -= filled_ - (n - 1);
    filled_ = n - 1;
  }
  history_.col(filled_) = values;
  overload_[static_cast<std::size_t>(filled_)] = overload;
  ++filled_;
  if (overload != 0) overloads_end_ = filled_;
  const bool may_be_given = count_ == 0;
  count_ = (count_ + 1) % factor_;
  if (!may_be_given) {
    std::ranges::fill(next_, std::nullopt);
    return;
  }
  remember_angles();
  if (filled_ < n) return;
  weighted_sum(history_.middleCols(filled_ - n, n), taps_, sum_);
  std::uint32_t any = 0;
  for (Eigen::Index i = filled_ - n; i < overloads_end_; ++i) any |= overload_[static_cast<std::size_t>(i)];
  emit_(std::span(waiting_).first(next_.size()), sum_, any);
}

}  // namespace roadbalance
