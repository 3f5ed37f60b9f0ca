#include "firmware/counter_encoder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace roadbalance {

CounterEncoder::CounterEncoder(const EncoderConfig& config, const SignalConfig& counter)
    : config_(config),
      unwrap_(of_ring(counter.counter, config.pulses_per_turn)),
      track_(counter.latency, counter.counter.step),
      angle_(config.pulses_per_turn) {}

void CounterEncoder::add(NodeTime time, EdgeKind kind) noexcept {
  if (kind != EdgeKind::kZeroMark || !config_.zero_mark) return;
  if (pending_marks_ == pending_ns_.size()) return;  // a bus that fell silent
  pending_ns_[pending_marks_++] = to_ns(time);
}

void CounterEncoder::add(NodeTime time, double code) noexcept {
  if (!(std::abs(code) < 1e15)) return;
  switch (unwrap_.take(to_ns(time), std::llround(code))) {
    case CounterUnwrap::Outcome::kInvalid:
    case CounterUnwrap::Outcome::kOutOfOrder:
      return;
    case CounterUnwrap::Outcome::kFirst:
    case CounterUnwrap::Outcome::kAmbiguous:
    case CounterUnwrap::Outcome::kImplausible:
      pending_marks_ = 0;  // their places in the new run are not known
      break;
    case CounterUnwrap::Outcome::kJoined:
      break;
  }
  track_.add(to_ns(time), unwrap_.count(), unwrap_.run());
  take_marks();
}

void CounterEncoder::take_marks() noexcept {
  std::size_t taken = 0;
  for (; taken < pending_marks_ && track_.behind(pending_ns_[taken]) >= kBehind; ++taken)
    // One from before the run, or a false one, is no loss: the next turn has another.
    static_cast<void>(angle_.mark(pending_ns_[taken], track_));
  std::copy(pending_ns_.begin() + static_cast<std::ptrdiff_t>(taken),
            pending_ns_.begin() + static_cast<std::ptrdiff_t>(pending_marks_), pending_ns_.begin());
  pending_marks_ -= taken;
}

bool CounterEncoder::angles(NodeTime first, double step_ns, std::span<double> angle_rad) const noexcept {
  if (angle_rad.empty()) return false;
  // The position is a quadratic, or nearly: three places determine it.
  const auto last = static_cast<double>(angle_rad.size() - 1);
  const auto instant = [&](double i) { return to_ns(first) + std::llround(i * step_ns); };
  const auto angle = angle_.at(instant(0.0), track_);
  const auto begin = track_.at(instant(0.0)), middle = track_.at(instant(0.5 * last)),
             end = track_.at(instant(last));
  if (!angle || !begin || !middle || !end) return false;
  const double per_pulse = 2.0 * std::numbers::pi / config_.pulses_per_turn;
  const double half = per_pulse * (middle->pulses - begin->pulses);
  const double whole = per_pulse * (end->pulses - begin->pulses);
  for (std::size_t i = 0; i < angle_rad.size(); ++i) {
    const double x = last > 0.0 ? static_cast<double>(i) / last : 0.0;
    angle_rad[i] =
        angle->angle_rad + config_.datum_rad + x * (4.0 * half - whole + x * (2.0 * whole - 4.0 * half));
  }
  return true;
}

double CounterEncoder::sigma_rad(NodeTime time) const noexcept {
  const auto angle = angle_.at(to_ns(time), track_);
  return angle ? angle->sigma_rad : std::numeric_limits<double>::infinity();
}

bool CounterEncoder::is_awaited(NodeTime time) const noexcept {
  const std::int64_t newest_ns = track_.newest_ns();
  return newest_ns > to_ns(time) - kSilence_ns && track_.behind(to_ns(time)) < kBehind;
}

}  // namespace roadbalance
