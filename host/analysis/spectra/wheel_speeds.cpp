#include "host/analysis/spectra/wheel_speeds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace roadbalance {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kUnknownSpeed = std::numeric_limits<double>::quiet_NaN();

}  // namespace

WheelSpeeds::WheelSpeeds(const VehicleConfig& vehicle) : class_m_s_(vehicle.drive.speed_class_m_s) {
  for (const NodeConfig& node : vehicle.node) {
    auto& wheels = wheel_of_.emplace(node.id, std::array<int, kEncoderLines>{}).first->second;
    wheels.fill(-1);
    for (int line = 0; line < kEncoderLines; ++line)
      if (const WheelConfig* const wheel = vehicle.wheel_at(node, line)) {
        const int place = vehicle.place_of(*wheel);
        wheels[static_cast<std::size_t>(line)] = place;
        rolling_radius_m_[static_cast<std::size_t>(place)] = wheel->rolling_radius_m;
        ++with_encoder_;
        if (!pace_) pace_ = node.id;
      }
  }
}

void WheelSpeeds::take(const Level& level) {
  const auto wheels = wheel_of_.find(level.node);
  if (wheels == wheel_of_.end()) return;
  if (level.node == pace_) clock_s_ += level.seconds;
  for (std::size_t line = 0; line < kEncoderLines; ++line) {
    const int wheel = wheels->second[line];
    if (wheel < 0) continue;
    Turning& turning = turning_[static_cast<std::size_t>(wheel)];
    turning.hz.reset();
    if (!std::isfinite(level.rotation_hz[line])) continue;
    turning.hz = level.rotation_hz[line];
    turning.at_s = clock_s_;
    turning.seconds += level.seconds;
    turning.turns += *turning.hz * level.seconds;
  }
  if (level.node == pace_) instant(level.seconds);
}

void WheelSpeeds::instant(double seconds) {
  std::array<double, kWheels> hz;
  int known = 0;
  double sum = 0.0, speed_m_s = 0.0;
  for (std::size_t w = 0; w < kWheels; ++w) {
    const Turning& turning = turning_[w];
    hz[w] = turning.hz && clock_s_ - turning.at_s <= kOldest_s ? *turning.hz : kUnknownSpeed;
    if (std::isnan(hz[w])) continue;
    ++known;
    sum += hz[w];
    speed_m_s += kTurn * rolling_radius_m_[w] * hz[w];
  }
  if (known == 0) return;
  const double place = std::floor(speed_m_s / known / class_m_s_);
  class_s_[static_cast<int>(std::clamp<double>(place, -kLastClass, kLastClass))] += seconds;
  for (std::size_t a = 0; a < kWheels; ++a)
    for (std::size_t b = a + 1; b < kWheels; ++b) {
      if (std::isnan(hz[a]) || std::isnan(hz[b])) continue;
      Drift& drift = drift_[a][b];
      drift.seen = true;
      drift.now += kTurn * (hz[a] - hz[b]) * seconds;
      drift.least = std::min(drift.least, drift.now);
      drift.most = std::max(drift.most, drift.now);
    }
  if (known < with_encoder_ || sum < known * kLeast_hz) return;
  for (std::size_t w = 0; w < kWheels; ++w)
    if (!std::isnan(hz[w])) together_turns_[w] += hz[w] * seconds;
}

std::array<WheelSpeeds::Wheel, kWheels> WheelSpeeds::wheels() const {
  const double mean = std::accumulate(together_turns_.begin(), together_turns_.end(), 0.0) /
                      static_cast<double>(std::max(1, with_encoder_));
  std::array<Wheel, kWheels> wheels;
  for (std::size_t w = 0; w < kWheels; ++w) {
    const bool comparable = with_encoder_ > 1 && mean > 0.0 && together_turns_[w] > 0.0;
    wheels[w] = {turning_[w].seconds, turning_[w].turns,
                 comparable ? together_turns_[w] / mean - 1.0 : kUnknownSpeed};
  }
  return wheels;
}

double WheelSpeeds::drift_rad(int a, int b) const {
  const Drift& drift =
      drift_[static_cast<std::size_t>(std::min(a, b))][static_cast<std::size_t>(std::max(a, b))];
  return drift.seen ? drift.most - drift.least : kUnknownSpeed;
}

}  // namespace roadbalance
