#include "common/angle/reference_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/dsp/linear_filter.hpp"

namespace roadbalance {
namespace {

constexpr double kLeastStepRate_hz = 4000.0;  // a sine of 18 Hz is then linear between steps to 7e-5

int steps_per_scan(double rate_hz) {
  return std::clamp(static_cast<int>(std::ceil(kLeastStepRate_hz / rate_hz)), 1, ReferenceFilter::kMostSteps);
}

/// Until the slowest pole of the Butterworth filter has decayed to 1e-5.
int settling_scans(const FilterConfig& filter, double rate_hz) {
  const double decay_per_s =
      2.0 * std::numbers::pi * filter.cutoff_hz * std::sin(std::numbers::pi / (2.0 * filter.order));
  return static_cast<int>(std::ceil(std::log(1e5) / decay_per_s * rate_hz));
}

}  // namespace

ReferenceFilter::ReferenceFilter(const FilterConfig& filter, double rate_hz)
    : steps_(steps_per_scan(rate_hz)),
      period_ns_(1e9 / rate_hz),
      settling_scans_(settling_scans(filter, rate_hz)),
      filter_(
          discretise_ramp_invariant(butterworth(filter.order, filter.cutoff_hz), 1.0 / (rate_hz * steps_)),
          kReferences) {
  unsettled_.fill(settling_scans_);
}

NodeTime ReferenceFilter::first_step(NodeTime first_scan) const noexcept {
  return first_scan - NodeClock::duration(std::llround(period_ns_ - step_ns()));
}

std::int32_t ReferenceFilter::fill(std::span<std::array<std::int32_t, kChannels>> scans,
                                   const Angles& angle_rad, bool after_jump) noexcept {
  if (after_jump) {
    filter_.reset();
    unsettled_.fill(settling_scans_);
  }
  std::int32_t quality = 0;
  for (std::size_t line = 0; line < kEncoderLines; ++line) {
    if (angle_rad[line].empty()) unsettled_[line] = settling_scans_;
    if (unsettled_[line] > 0) quality |= quality_no_reference(static_cast<int>(line));
  }
  Eigen::Array<double, kReferences, 1> input = Eigen::Array<double, kReferences, 1>::Zero();
  std::size_t at = 0;
  for (auto& scan : scans) {
    for (int step = 0; step < steps_; ++step, ++at) {
      for (std::size_t line = 0; line < kEncoderLines; ++line) {
        const auto row = static_cast<Eigen::Index>(2 * line);
        if (angle_rad[line].empty()) continue;
        const double angle = angle_rad[line][at];
        input(row) = std::sin(angle);  // one call gives both
        input(row + 1) = std::cos(angle);
      }
      filter_.update(input);
    }
    for (std::size_t line = 0; line < kEncoderLines; ++line) {
      const bool known = !angle_rad[line].empty();
      for (std::size_t part = 0; part < 2; ++part) {
        const double value = filter_.states()(static_cast<Eigen::Index>(2 * line + part), 0);
        scan[kAccelerations + 2 * line + part] =
            known ? static_cast<std::int32_t>(std::lround(value * kFullScaleCounts)) : 0;
      }
      if (known && unsettled_[line] > 0) --unsettled_[line];
    }
  }
  return quality;
}

}  // namespace roadbalance
