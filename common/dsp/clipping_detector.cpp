#include "common/dsp/clipping_detector.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace roadbalance {
namespace {

constexpr int kFlatTops = 16, kRoundedTops = 24;
constexpr int kFlatSteps = 16, kRoundedSteps = 40;  // 2 % and 5 % of fewer are no whole step
constexpr std::int64_t kShortest = 3;               // samples of a top

}  // namespace

/// Makes bins twice as wide until one holds the distance.
void ClippingDetector::Side::widen(std::int64_t steps) {
  const auto halve = [](auto& bins) {
    for (std::size_t i = 0; i < kBins / 2; ++i) bins[i] = bins[2 * i] + bins[2 * i + 1];
    std::fill(bins.begin() + kBins / 2, bins.end(), 0);
  };
  for (; bin(steps) >= kBins; ++shift) {
    halve(samples);
    halve(tops);
    halve(falls);
  }
}

void ClippingDetector::Side::end_top(std::int64_t steps) {
  const auto top = static_cast<std::size_t>(bin(steps)), last = static_cast<std::size_t>(bin(last_top));
  ++tops[top];
  if (last > top) {
    ++falls[last];
    --falls[top];
  }
  last_top = steps;
}

ClippingDetector::ClippingDetector(double rate_hz) : second_(std::lround(rate_hz)) {
  if (!(rate_hz > 0.0))
    throw std::invalid_argument("rate_hz " + std::to_string(rate_hz) + " is not positive");
  second_ = std::max<std::int64_t>(second_, 1);
}

bool ClippingDetector::add(std::int32_t counts) noexcept {
  if (last_ && *last_ != counts) {
    const std::int64_t difference = std::abs(static_cast<std::int64_t>(counts) - *last_);
    if (least_difference_ == 0 || difference < least_difference_) least_difference_ = difference;
  }
  last_ = counts;
  const std::int64_t off = counts - static_cast<std::int64_t>(rest_.value_or(0));
  ++now_.samples;
  now_.sum += off;
  now_.squares += off * off;
  if (rest_) place(counts);
  if (now_.samples < second_) return false;
  end_second();
  return true;
}

void ClippingDetector::skip() noexcept {
  last_.reset();
  at_.reset();
}

void ClippingDetector::restart() noexcept {
  *this = ClippingDetector(static_cast<double>(second_));
}

/// Counts the sample; where it has gone to the other side of the rest by more than it does on average, the
/// top on this side is over.
void ClippingDetector::place(std::int32_t counts) noexcept {
  const std::int64_t off = counts - static_cast<std::int64_t>(*rest_);
  const std::size_t side = off < 0 ? 1 : 0;
  const std::int64_t steps = (std::abs(off) + step_ / 2) / step_;
  side_[side].widen(steps);
  ++side_[side].samples[static_cast<std::size_t>(side_[side].bin(steps))];
  if (side != at_.value_or(2) && off * off * before_.samples > before_.squares) {
    if (at_) side_[*at_].end_top(top_);
    at_ = side;
    top_ = 0;
  }
  if (side == at_) top_ = std::max(top_, steps);
}

void ClippingDetector::end_second() noexcept {
  before_ = now_;
  now_ = {};
  if (!rest_) {
    if (least_difference_ > 0) begin(static_cast<std::int32_t>(before_.sum / before_.samples));
    return;
  }
  // Bins of many steps do not show how large a step is.
  const bool fine = std::min(side_[0].shift, side_[1].shift) < 3;
  if ((fine && least_difference_ < step_) || moved_away())
    return begin(*rest_ + static_cast<std::int32_t>(before_.sum / before_.samples));
  for (std::size_t side = 0; side < side_.size(); ++side) judge(side);
}

/// All that is known begins anew at the newest sample next to `rest`, from where whole steps lead to all
/// others.
void ClippingDetector::begin(std::int32_t rest) noexcept {
  step_ = least_difference_;
  const std::int64_t newest = last_.value_or(rest);
  const std::int64_t steps = std::llround(static_cast<double>(rest - newest) / static_cast<double>(step_));
  const auto from = static_cast<std::int64_t>(rest_.value_or(0));
  rest_ = static_cast<std::int32_t>(newest + steps * step_);
  // The squares about the new rest.
  const std::int64_t moved = *rest_ - from;
  before_.squares += before_.samples * moved * moved - 2 * moved * before_.sum;
  before_.sum -= before_.samples * moved;
  minute_ = {};
  side_ = {};
  at_.reset();
  limits_ = {.low = {}, .high = {}, .rest = *rest_};
}

/// The mean of a minute is further from the rest than the channel moves: another zero.
bool ClippingDetector::moved_away() noexcept {
  minute_.samples += before_.samples;
  minute_.sum += before_.sum;
  minute_.squares += before_.squares / before_.samples;
  if (minute_.samples < kMinute_s * second_) return false;
  const double mean = static_cast<double>(minute_.sum) / static_cast<double>(minute_.samples);
  const double square = static_cast<double>(minute_.squares) / kMinute_s;
  minute_ = {};
  return mean * mean > 0.8 * square;  // the variance is less than a quarter of it
}

void ClippingDetector::judge(std::size_t side) noexcept {
  Side& of = side_[side];
  beyond_.samples[kBins] = beyond_.tops[kBins] = beyond_.falls[kBins] = 0;
  int top = 0;
  for (int b = kBins - 1; b >= 0; --b) {
    const auto i = static_cast<std::size_t>(b);
    beyond_.samples[i] = beyond_.samples[i + 1] + of.samples[i];
    beyond_.tops[i] = beyond_.tops[i + 1] + of.tops[i];
    beyond_.falls[i] = beyond_.falls[i + 1] + of.falls[i];
    if (top == 0 && of.samples[i] > 0) top = b;
  }
  if (of.limit && is_passed(of.bin(*of.limit))) of.limit.reset();
  for (int b = top; b > top / 2 && !of.limit; --b)
    if (is_flat(b) || is_rounded(b)) of.limit = static_cast<std::int64_t>(b) << of.shift;
  std::optional<std::int32_t>& limit = side == 0 ? limits_.high : limits_.low;
  limit.reset();
  if (!of.limit) return;
  const std::int64_t off = *of.limit * step_;
  limit = static_cast<std::int32_t>(*rest_ + (side == 0 ? off : -off));
}

bool ClippingDetector::is_passed(int bin) const noexcept {
  const auto from = [this](int at) {
    return beyond_.samples[static_cast<std::size_t>(std::clamp(at, 0, kBins))];
  };
  const int width = std::max(1, bin / 20);
  return 10 * from(bin + width + 1) > 3 * from(bin - width);
}

bool ClippingDetector::is_flat(int bin) const noexcept {
  const auto from = [bin](const auto& beyond, int below) {
    return beyond[static_cast<std::size_t>(std::max(0, bin - below))];
  };
  const int width = std::max(1, bin / 50);
  if (bin < kFlatSteps) return false;
  const std::int64_t beyond = from(beyond_.samples, -1);
  const std::int64_t reach = from(beyond_.samples, width - 1), here = reach - beyond;
  const std::int64_t inside =
      from(beyond_.samples, 5 * width - 1) - from(beyond_.samples, 2 * width - 1);  // three widths
  const std::int64_t tops = from(beyond_.tops, width - 1), falls = from(beyond_.falls, width - 1);
  return tops >= kFlatTops && beyond <= here && 3 * here >= 5 * inside && reach >= kShortest * tops &&
         (8 * falls >= tops || 3 * here >= beyond_.samples[0]);
}

bool ClippingDetector::is_rounded(int bin) const noexcept {
  const auto from = [](const auto& beyond, int at) {
    return beyond[static_cast<std::size_t>(std::clamp(at, 0, kBins))];
  };
  if (bin < kRoundedSteps) return false;
  const int width = bin / 20;
  const std::int64_t beyond = from(beyond_.samples, bin + width + 1);
  const std::int64_t reach = from(beyond_.samples, bin - width);
  const std::int64_t inside = from(beyond_.samples, bin - 3 * width) - reach;
  const std::int64_t tops = from(beyond_.tops, bin - width), falls = from(beyond_.falls, bin - width);
  const std::int64_t lower = from(beyond_.tops, bin - 6 * width) - from(beyond_.tops, bin - 2 * width);
  if (tops < kRoundedTops || reach < kShortest * tops || 4 * falls < tops || 4 * lower < tops) return false;
  const double rise = 1.0 + 1.5 / std::sqrt(static_cast<double>(tops));
  return 20 * beyond <= 3 * reach &&
         static_cast<double>(reach - beyond) >= rise * static_cast<double>(inside);
}

}  // namespace roadbalance
