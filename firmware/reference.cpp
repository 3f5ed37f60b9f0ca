#include "firmware/reference.hpp"

#include <algorithm>
#include <cmath>

#include "common/angle/wanted_signal.hpp"
#include "common/types/angle_sigma.hpp"

namespace roadbalance {

Reference::Reference(const VehicleConfig& vehicle, const NodeConfig& node)
    : filter_(vehicle.filter, node.rate_hz), steering_signal_(steering_signal(node.wiring)) {
  for (int number = 0; number < kEncoderLines; ++number) {
    const WheelConfig* const wheel = vehicle.wheel_at(node, number);
    if (!wheel) continue;
    const auto line = static_cast<std::size_t>(number);
    steering_ratio_[line] = wheel->encoder.steering_ratio;
    counter_signal_[line] = counter_signal(node.wiring, wheel->encoder.counter);
    if (counter_signal_[line])
      counter_[line].emplace(wheel->encoder, *node.wiring.signal(*counter_signal_[line]));
    else
      encoder_[line].emplace(wheel->encoder);
  }
}

void Reference::add(const Edge& edge) noexcept {
  if (edge.line >= kEncoderLines) return;
  if (encoder_[edge.line]) encoder_[edge.line]->add(edge.time, edge.kind);
  if (counter_[edge.line]) counter_[edge.line]->add(edge.time, edge.kind);
}

void Reference::add(std::span<const SignalSample> samples) noexcept {
  for (const SignalSample& sample : samples) {
    if (sample.signal == steering_signal_) steering_.add(to_ns(sample.time), sample.value);
    for (std::size_t line = 0; line < kEncoderLines; ++line)
      if (counter_[line] && sample.signal == counter_signal_[line])
        counter_[line]->add(sample.time, sample.value);
  }
}

NodeTime Reference::complete_at(NodeTime last) const noexcept {
  NodeTime complete = last;
  for (const auto& encoder : encoder_)
    if (encoder) complete = std::max(complete, encoder->complete_at(last));
  return complete;
}

bool Reference::locate(NodeTime first, int scans) noexcept {
  const NodeTime from = filter_.first_step(first);
  const NodeTime last = first + NodeClock::duration(std::llround((scans - 1) * filter_.period_ns()));
  bool all = true;
  for (std::size_t line = 0; line < kEncoderLines; ++line) {
    const auto angle_rad = std::span(angle_rad_[line]).first(static_cast<std::size_t>(filter_.steps(scans)));
    known_[line] = {};
    uncertain_[line] = encoder_[line] ? encoder_[line]->uncertain(first, last)
                                      : counter_[line] && counter_[line]->uncertain();
    if (!encoder_[line] && !counter_[line]) continue;
    if (!look_up(line, from, last, angle_rad)) all = false;
  }
  return all;
}

/// False if the angle is not known, or soon will be better.
bool Reference::look_up(std::size_t line, NodeTime from, NodeTime last,
                        std::span<double> angle_rad) noexcept {
  const bool known = encoder_[line] ? encoder_[line]->angles(from, filter_.step_ns(), angle_rad)
                                    : counter_[line]->angles(from, filter_.step_ns(), angle_rad);
  if (!known) return false;
  known_[line] = angle_rad;
  sigma_rad_[line] = encoder_[line]
                         ? encoder_[line]->sigma_rad()
                         : std::max(counter_[line]->sigma_rad(from), counter_[line]->sigma_rad(last));
  const bool awaited = counter_[line] && counter_[line]->is_awaited(last);
  const bool steered = steering_ratio_[line] == 0.0 || steer(line, from, angle_rad);
  return steered && !awaited;
}

/// False if the next message will improve it.
bool Reference::steer(std::size_t line, NodeTime from, std::span<double> angle_rad) noexcept {
  if (!steering_.take_out(steering_ratio_[line], to_ns(from), filter_.step_ns(), angle_rad))
    uncertain_[line] = true;
  const double last_ns = filter_.step_ns() * static_cast<double>(angle_rad.size() - 1);
  return !steering_.is_awaited(to_ns(from) + std::llround(last_ns));
}

std::int32_t Reference::fill(std::span<std::array<std::int32_t, kChannels>> scans, bool after_jump) noexcept {
  constexpr std::array<std::int32_t, kEncoderLines> kUncertain{kQualityUncertainAngle0,
                                                               kQualityUncertainAngle1};
  std::int32_t quality = 0;
  for (std::size_t line = 0; line < kEncoderLines; ++line)
    if (uncertain_[line]) quality |= kUncertain[line];
  if (!has_encoder(0) && !has_encoder(1)) {
    for (auto& scan : scans) std::fill(scan.begin() + kAccelerations, scan.end(), 0);
    return quality | quality_no_reference(0) | quality_no_reference(1);  // nothing to filter
  }
  return quality | fill_known(scans, after_jump);
}

std::int32_t Reference::fill_known(std::span<std::array<std::int32_t, kChannels>> scans,
                                   bool after_jump) noexcept {
  std::int32_t quality = filter_.fill(scans, known_, after_jump);
  for (int line = 0; line < kEncoderLines; ++line)
    if (!known_[static_cast<std::size_t>(line)].empty())
      quality = with_angle_sigma(quality, line, sigma_rad_[static_cast<std::size_t>(line)]);
  return quality;
}

EncoderFaults Reference::faults(int line) const noexcept {
  const auto at = static_cast<std::size_t>(line);
  if (counter_[at])
    return {.breaks = counter_[at]->breaks(),
            .marks_elsewhere = counter_[at]->marks_elsewhere(),
            .mark_counts = counter_[at]->mark_counts()};
  if (!encoder_[at]) return {};
  return {.turns = encoder_[at]->faulty_turns(), .mark_counts = encoder_[at]->mark_counts()};
}

}  // namespace roadbalance
