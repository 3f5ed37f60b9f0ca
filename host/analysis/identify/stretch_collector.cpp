#include "host/analysis/identify/stretch_collector.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/analysis/identify/rotation.hpp"

namespace roadbalance {
namespace {

constexpr int kLongest_s = 60;
constexpr double kSettling_s = 3.0;         ///< of the suspension, after a hole
constexpr double kSecondSteadiness = 0.02;  ///< a second's speed may differ from the stretch's by this share

}  // namespace

StretchCollector::StretchCollector(const VehicleConfig& vehicle, Emit emit)
    : vehicle_(vehicle),
      rate_hz_(vehicle.drive.identification_rate_hz),
      second_(std::max<Eigen::Index>(2, std::lround(rate_hz_))),
      least_(std::lround(vehicle.drive.section_s * rate_hz_)),
      signals_(kSignals, kLongest_s * second_),
      road_m_(kWheels, kLongest_s * second_),
      emit_(std::move(emit)) {}

void StretchCollector::consume(const IdentificationSample& sample) {
  if (sample.restart) {
    if (!sample.spoiled) finish();
    filled_ = 0;
    settling_ = std::lround(kSettling_s * rate_hz_);
  }
  if (settling_ > 0) {
    --settling_;
    return;
  }
  signals_.col(filled_) = sample.signals;
  road_measured_ = sample.road_m.has_value();
  if (road_measured_) road_m_.col(filled_) = *sample.road_m;
  ++filled_;
  if (filled_ % second_ == 0) take_second();
  if (filled_ == signals_.cols()) finish();
}

void StretchCollector::finish() {
  close(filled_);
  filled_ = 0;
}

/// The newest second: it goes on with the stretch, begins another, or is dropped.
void StretchCollector::take_second() {
  const Eigen::Index before = filled_ - second_;
  std::optional<double> speed_m_s, speed_before_m_s;
  bool complete = true;
  for (int wheel = 0; wheel < kWheels; ++wheel) {
    const WheelConfig& config = vehicle_.wheel[static_cast<std::size_t>(wheel)];
    if (config.node.empty()) continue;
    const auto newest = mean_rotation(signals_.middleCols(before, second_), wheel, rate_hz_);
    if (!newest) complete = false;
    if (!newest || speed_m_s) continue;
    speed_m_s = *newest * config.rolling_radius_m;
    if (before == 0) continue;
    speed_before_m_s = *mean_rotation(signals_.leftCols(before), wheel, rate_hz_) * config.rolling_radius_m;
  }
  if (!complete || !speed_m_s || *speed_m_s < vehicle_.drive.least_speed_m_s) {
    close(before);
    filled_ = 0;
  } else if (speed_before_m_s && std::abs(*speed_m_s / *speed_before_m_s - 1.0) > kSecondSteadiness) {
    close(before);
    signals_.leftCols(second_) = signals_.middleCols(before, second_).eval();
    road_m_.leftCols(second_) = road_m_.middleCols(before, second_).eval();
    filled_ = second_;
  }
}

/// Hands over the first `samples`, if they are enough.
void StretchCollector::close(Eigen::Index samples) {
  samples -= samples % second_;  // what take_second has seen
  if (samples == 0 || samples < least_) return;
  Stretch stretch;
  stretch.rate_hz = rate_hz_;
  stretch.signals = signals_.leftCols(samples);
  if (road_measured_) stretch.road_m = road_m_.leftCols(samples);
  for (int wheel = 0; wheel < kWheels; ++wheel) {
    const WheelConfig& config = vehicle_.wheel[static_cast<std::size_t>(wheel)];
    const auto omega = mean_rotation(stretch.signals, wheel, rate_hz_);
    if (config.node.empty() || !omega) continue;
    stretch.omega(wheel) = *omega;
    if (stretch.speed_m_s == 0.0) stretch.speed_m_s = *omega * config.rolling_radius_m;
  }
  emit_(stretch);
}

}  // namespace roadbalance
