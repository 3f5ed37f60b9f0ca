#include "host/analysis/orders/fewer_samples.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "common/dsp/decimation.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kBehind = 8;  // samples that are given, of which the low-pass has the later half

}  // namespace

FewerSamples::FewerSamples(int channels, int factor, Emit emit)
    : factor_(factor),
      taps_(decimation_taps(factor).size()),
      low_pass_(channels, factor, decimation_taps(factor)),
      emit_(std::move(emit)) {
  follow(1);
}

void FewerSamples::follow(std::size_t angles) {
  next_.resize(angles);
  lost_.resize(angles);
  waiting_.resize((kBehind + 1) * angles);
  interrupt();
}

void FewerSamples::interrupt() {
  low_pass_.restart(0);
  count_ = 0;
  samples_ = 0;
  overload_.fill(-taps_);
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
  ++samples_;
  for (std::uint32_t left = overload; left != 0; left &= left - 1)
    overload_[static_cast<std::size_t>(std::countr_zero(left))] = samples_;
  const bool is_given = low_pass_.add(values), may_be_given = count_ == 0;
  count_ = (count_ + 1) % factor_;
  if (!may_be_given) {
    std::ranges::fill(next_, std::nullopt);
    return;
  }
  remember_angles();
  if (is_given) emit_(std::span(waiting_).first(next_.size()), low_pass_.output(), overloads());
}

std::uint32_t FewerSamples::overloads() const {
  std::uint32_t any = 0;
  for (std::size_t k = 0; k < overload_.size(); ++k)
    if (overload_[k] > samples_ - taps_) any |= std::uint32_t{1} << k;
  return any;
}

}  // namespace roadbalance
