#include "host/analysis/orders/angle_sampler.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "common/dsp/weighted_sum.hpp"

namespace roadbalance {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
/// Share of a step: Newton's next correction would be about its square, below the resolution of a double.
constexpr double kNewtonEnough = 1e-7;

const AngleSampler::Settings& checked(const AngleSampler::Settings& settings) {
  if (settings.channels < 1) throw std::invalid_argument("angle sampler: it needs at least one channel");
  if (!(settings.rate_hz > 0.0 && settings.least_rotation_hz > 0.0))
    throw std::invalid_argument("angle sampler: sampling rate and least rotation must be positive");
  if (!(settings.rows_per_turn * settings.least_rotation_hz >= settings.rate_hz * (1.0 - 1e-9)))
    throw std::invalid_argument("angle sampler: fewer rows than samples at the least rotation would fold");
  return settings;
}

}  // namespace

AngleSampler::AngleSampler(const Settings& settings, Emit emit)
    : settings_(checked(settings)),
      step_rad_(kTurn_rad / settings.rows_per_turn),
      values_(settings.channels, kCapacity),
      sample_(static_cast<std::size_t>(kCapacity)),
      emit_(std::move(emit)) {
  row_.values.resize(settings.channels);
}

void AngleSampler::add(std::optional<double> angle_rad, const Eigen::Ref<const Eigen::VectorXd>& values,
                       std::uint32_t overload) {
  assert(values.size() == settings_.channels);
  ++came_;
  if (!angle_rad || !std::isfinite(*angle_rad)) return interrupt();
  push(*angle_rad, values, overload);
  emit_complete();
}

void AngleSampler::push(double angle_rad, const Eigen::Ref<const Eigen::VectorXd>& values,
                        std::uint32_t overload) {
  if (filled_ > 0) {
    const double last = sample(filled_ - 1).angle_rad;
    const double turned = std::remainder(angle_rad - last, kTurn_rad);
    if (std::abs(turned) > kFastest * kTurn_rad)
      interrupt();
    else
      angle_rad = last + turned;
  }
  if (filled_ == 0) {
    angle_rad -= kTurn_rad * std::floor(angle_rad / kTurn_rad);
    at_ = FractionalDelay::kBefore;
    restart_ = true;
  }
  if (filled_ == kCapacity) {
    const Eigen::Index gone = at_ - FractionalDelay::kBefore, kept = filled_ - gone;
    values_.leftCols(kept) = values_.middleCols(gone, kept).eval();
    std::copy_n(sample_.begin() + gone, kept, sample_.begin());
    filled_ = kept;
    at_ -= gone;
  }
  values_.col(filled_) = values;
  sample_[static_cast<std::size_t>(filled_)] = {angle_rad, overload};
  ++filled_;
}

/// Around the step from sample at_ to the next; a single step may be short by the angle's own noise.
bool AngleSampler::turns_here() const {
  const Eigen::Index first = at_ - FractionalDelay::kBefore, last = at_ + FractionalDelay::kAfter;
  const double turned_rad = sample(last).angle_rad - sample(first).angle_rad;
  const double least_rad = kTurn_rad * settings_.least_rotation_hz / settings_.rate_hz;
  return turned_rad >= least_rad * static_cast<double>(last - first) &&
         sample(at_ + 1).angle_rad > sample(at_).angle_rad;
}

void AngleSampler::emit_complete() {
  for (; at_ + FractionalDelay::kAfter < filled_; ++at_) {
    if (!turns_here()) {
      ++slow_samples_;
      restart_ = true;
      continue;
    }
    const double from = sample(at_).angle_rad, to = sample(at_ + 1).angle_rad;
    if (restart_) row_.index = static_cast<std::int64_t>(std::ceil(from / step_rad_));
    if (!(static_cast<double>(row_.index) * step_rad_ < to)) continue;
    const Step step = step_here();
    for (; static_cast<double>(row_.index) * step_rad_ < to; ++row_.index)
      emit_row(step.part(static_cast<double>(row_.index) * step_rad_));
  }
}

AngleSampler::Step AngleSampler::step_here() const {
  const double a = sample(at_ - 1).angle_rad, b = sample(at_).angle_rad, c = sample(at_ + 1).angle_rad,
               d = sample(at_ + 2).angle_rad;
  // From b on: of the angle itself, which grows all through a run, the last digits would be lost.
  const double before = a - b, after = c - b, later = d - b;
  return {b, after, -before / 3.0 + after - later / 6.0, (before + after) / 2.0,
          (later - before) / 6.0 - after / 2.0};
}

/// By Newton's method from the straight line.
double AngleSampler::Step::part(double angle_rad) const {
  const double wanted = angle_rad - from_rad;
  double part = wanted / turned_rad;
  for (int step = 0; step < 3; ++step) {
    const double slope = c1 + part * (2.0 * c2 + part * 3.0 * c3);
    if (!(slope > 0.0)) break;
    const double short_by = (part * (c1 + part * (c2 + part * c3)) - wanted) / slope;
    part -= short_by;
    if (std::abs(short_by) < kNewtonEnough) break;
  }
  return std::clamp(part, 0.0, 1.0);
}

void AngleSampler::emit_row(double part) {
  const Eigen::Index first = at_ - FractionalDelay::kBefore;
  row_.restart = std::exchange(restart_, false);
  row_.time_s = (static_cast<double>(came_ - (filled_ - at_)) + part) / settings_.rate_hz;
  weighted_sum(values_.middleCols<FractionalDelay::kTaps>(first), delay_.taps(part), row_.values);
  row_.overload = 0;
  for (Eigen::Index i = first; i < first + FractionalDelay::kTaps; ++i) row_.overload |= sample(i).overload;
  emit_(row_);
}

}  // namespace roadbalance
