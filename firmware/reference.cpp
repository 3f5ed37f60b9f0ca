#include "firmware/reference.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/dsp/linear_filter.hpp"

namespace roadbalance {

namespace {

constexpr double kLeastStepRate_hz = 4000.0;  // a sine of 18 Hz is then linear between steps to 7e-5

int steps_per_scan(double rate_hz) {
  return std::clamp(static_cast<int>(std::ceil(kLeastStepRate_hz / rate_hz)), 2, 32);
}

/// Until the slowest pole of the Butterworth filter has decayed to 1e-5.
int settling_scans(const FilterConfig& filter, double rate_hz) {
  const double decay_per_s =
      2.0 * std::numbers::pi * filter.cutoff_hz * std::sin(std::numbers::pi / (2.0 * filter.order));
  return static_cast<int>(std::ceil(std::log(1e5) / decay_per_s * rate_hz));
}

}  // namespace

Reference::Reference(const VehicleConfig& vehicle, const NodeConfig& node)
    : steps_(steps_per_scan(node.rate_hz)),
      period_ns_(1e9 / node.rate_hz),
      settling_scans_(settling_scans(vehicle.filter, node.rate_hz)),
      filter_(discretise_ramp_invariant(butterworth(vehicle.filter.order, vehicle.filter.cutoff_hz),
                                        1.0 / (node.rate_hz * steps_)),
              kReferences) {
  for (int line = 0; line < kEncoderLines; ++line) {
    if (const WheelConfig* const wheel = vehicle.wheel_at(node, line))
      encoder_[static_cast<std::size_t>(line)].emplace(wheel->encoder);
  }
  unsettled_.fill(settling_scans_);
}

void Reference::add(const Edge& edge) noexcept {
  if (edge.line < kEncoderLines && encoder_[edge.line]) encoder_[edge.line]->add(edge.time, edge.kind);
}

NodeTime Reference::complete_at(NodeTime last) const noexcept {
  NodeTime complete = last;
  for (const auto& encoder : encoder_)
    if (encoder) complete = std::max(complete, encoder->complete_at(last));
  return complete;
}

bool Reference::locate(NodeTime first, int scans) noexcept {
  const double step_ns = period_ns_ / steps_;
  // The filter's steps end at the scan: the first lies one step after the scan before.
  const auto lead_ns = static_cast<std::int64_t>(std::llround(period_ns_ - step_ns));
  bool all = true;
  for (std::size_t line = 0; line < encoder_.size(); ++line) {
    known_[line] =
        encoder_[line] &&
        encoder_[line]->angles(first - NodeClock::duration(lead_ns), step_ns,
                               std::span(angle_rad_[line]).first(static_cast<std::size_t>(scans * steps_)));
    if (encoder_[line] && !known_[line]) all = false;
    uncertain_[line] =
        encoder_[line] &&
        encoder_[line]->uncertain(first, first + NodeClock::duration(std::llround((scans - 1) * period_ns_)));
  }
  return all;
}

std::int32_t Reference::fill(std::span<std::array<std::int32_t, kChannels>> scans, bool after_jump) noexcept {
  if (after_jump) {
    filter_.reset();
    unsettled_.fill(settling_scans_);
  }
  constexpr std::array<std::int32_t, kEncoderLines> kUncertain{kQualityUncertainAngle0,
                                                               kQualityUncertainAngle1};
  std::int32_t quality = 0;
  for (std::size_t line = 0; line < kEncoderLines; ++line) {
    if (!known_[line]) unsettled_[line] = settling_scans_;
    if (!known_[line] || unsettled_[line] > 0) quality |= quality_no_reference(static_cast<int>(line));
    if (uncertain_[line]) quality |= kUncertain[line];
  }
  if (!has_encoder(0) && !has_encoder(1)) {
    for (auto& scan : scans) std::fill(scan.begin() + kAccelerations, scan.end(), 0);
    return quality;  // nothing to filter
  }
  Eigen::Array<double, kReferences, 1> input = Eigen::Array<double, kReferences, 1>::Zero();
  std::size_t at = 0;
  for (auto& scan : scans) {
    for (int step = 0; step < steps_; ++step, ++at) {
      for (std::size_t line = 0; line < kEncoderLines; ++line) {
        const auto row = static_cast<Eigen::Index>(2 * line);
        input(row) = known_[line] ? std::sin(angle_rad_[line][at]) : 0.0;
        input(row + 1) = known_[line] ? std::cos(angle_rad_[line][at]) : 0.0;
      }
      filter_.update(input);
    }
    for (std::size_t line = 0; line < kEncoderLines; ++line) {
      for (std::size_t part = 0; part < 2; ++part) {
        const double value = filter_.states()(static_cast<Eigen::Index>(2 * line + part), 0);
        scan[kAccelerations + 2 * line + part] =
            known_[line] ? static_cast<std::int32_t>(std::lround(value * kFullScaleCounts)) : 0;
      }
      if (known_[line] && unsettled_[line] > 0) --unsettled_[line];
    }
  }
  return quality;
}

}  // namespace roadbalance
