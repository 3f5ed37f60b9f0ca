#include "common/angle/pitch_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/angle/least_squares.hpp"

namespace roadbalance {

namespace {
constexpr int kForgetAfter = 1000;        // residuals; two a turn
constexpr std::size_t kTeethForFit = 64;  // a turn of the polynomial needs no more points
constexpr double kOutlier = 4.0;          // times the rms residual
}  // namespace

PitchTable::PitchTable(int teeth)
    : error_(static_cast<std::size_t>(teeth), 0.0), weight_(static_cast<std::size_t>(teeth), 0) {}

void PitchTable::learn(const ToothHistory& history, std::int64_t first, std::int64_t origin) noexcept {
  const auto teeth = static_cast<std::int64_t>(error_.size());
  const std::size_t begin = history.first_numbered(first);
  const std::size_t end = history.first_numbered(first + kTurns * teeth);
  if (end <= begin || 10 * (end - begin) < 9 * static_cast<std::size_t>(kTurns * teeth)) return;

  const std::int64_t t0 = history[begin].time_ns;
  const double half_ns = 0.5 * static_cast<double>(history[end - 1].time_ns - t0);
  const auto scaled = [&](const NumberedTooth& tooth) {
    return static_cast<double>(tooth.time_ns - t0) / half_ns - 1.0;
  };
  const auto nominal = [&](const NumberedTooth& tooth) { return static_cast<double>(tooth.number - first); };

  LeastSquares<5> turns;
  const std::size_t stride = (error_.size() + kTeethForFit - 1) / kTeethForFit;
  for (std::size_t i = begin; i < end; i += stride)
    turns.add(scaled(history[i]), nominal(history[i]) + error_[place(history[i].number - origin)]);
  if (!turns.solve()) return;

  // Only the middle turns: a polynomial is least certain at its ends.
  const std::size_t from = history.first_numbered(first + (kTurns / 2 - 1) * teeth);
  const std::size_t to = history.first_numbered(first + (kTurns / 2 + 1) * teeth);
  double square = 0.0;
  const auto change = [&](std::size_t i) {
    return turns.value(scaled(history[i])) - nominal(history[i]) - error_[place(history[i].number - origin)];
  };
  for (std::size_t i = from; i < to; ++i) square += change(i) * change(i);
  square /= static_cast<double>(std::max<std::size_t>(1, to - from));
  const double limit = kOutlier * std::sqrt(square);
  for (std::size_t i = from; i < to; ++i) {
    const double residual = change(i);
    if (std::abs(residual) > limit) continue;
    const std::size_t k = place(history[i].number - origin);
    weight_[k] = std::min(weight_[k] + 1, kForgetAfter);
    error_[k] += residual / weight_[k];
  }
  make_zero_mean();
  ++refinements_;
  scatter_ += (square - scatter_) / std::min(refinements_, 100);
  weigh();
}

void PitchTable::weigh() noexcept {
  double square = 0.0;
  for (const double e : error_) square += e * e;
  square /= static_cast<double>(error_.size());
  const double variance = sigma_pitches() * sigma_pitches();
  trust_ = square > variance ? 1.0 - variance / square : 0.0;
}

void PitchTable::forget() noexcept {
  std::ranges::fill(error_, 0.0);
  std::ranges::fill(weight_, 0);
  refinements_ = 0;
  scatter_ = trust_ = 0.0;
}

void PitchTable::make_zero_mean() noexcept {
  double mean = 0.0;
  for (const double e : error_) mean += e;
  mean /= static_cast<double>(error_.size());
  for (double& e : error_) e -= mean;
}

double PitchTable::sigma_pitches() const noexcept {
  if (refinements_ == 0) return std::numeric_limits<double>::infinity();
  return std::sqrt(scatter_ / std::min(refinements_, kForgetAfter / 2));
}

}  // namespace roadbalance
