#include "host/analysis/twin/sample_history.hpp"

#include <algorithm>
#include <complex>

namespace roadbalance {
namespace {

constexpr double kKnownPower = 0.25;  // of a reference; 0 is sent where the angle is not known

}  // namespace

SampleHistory::SampleHistory(const TwinChannels& channels, double rate_hz)
    : wheels_from_(channels.wheels_from),
      sensors_(channels.wheels_from.cols()),
      rate_hz_(rate_hz),
      values_(Eigen::MatrixXd::Zero(sensors_ + 2 * kWheels, 4 * kKept)),
      drive_(decltype(drive_)::Zero(2 * kWheels, values_.cols())),
      angle_(decltype(angle_)::Zero(kWheels, values_.cols())),
      steps_(decltype(steps_)::Zero(kWheels, values_.cols())),
      rolled_(decltype(rolled_)::Zero(3, values_.cols())),
      time_ns_(static_cast<std::size_t>(values_.cols())) {}

void SampleHistory::restart() {
  base_ = 0;
  filled_ = 0;
}

void SampleHistory::make_room() {
  if (filled_ < values_.cols()) return;
  const Eigen::Index from = filled_ - kKept;
  const auto move = [&](auto& matrix) {  // the two do not overlap
    matrix.leftCols(kKept) = matrix.middleCols(from, kKept);
  };
  move(values_);
  move(drive_);
  move(angle_);
  move(steps_);
  move(rolled_);
  std::copy_n(time_ns_.begin() + from, kKept, time_ns_.begin());
  base_ += from;
  filled_ = kKept;
}

void SampleHistory::add(const SensorSample& sample, const TwinCar& car) {
  make_room();
  const Eigen::Index k = filled_++;
  values_.col(k) = sample.values;
  time_ns_[static_cast<std::size_t>(k)] = sample.time_ns;
  drive_.col(k).head<kWheels>().noalias() = wheels_from_ * sample.values.head(sensors_);
  drive_.col(k).tail<kWheels>().setZero();
  roll(car);
  find_forces(car);
}

/// Turns angles and ways on by what has come last.
void SampleHistory::roll(const TwinCar& car) {
  const Eigen::Index k = filled_ - 1;
  rolled_.col(k).setZero();
  angle_.col(k).setZero();
  steps_.col(k).setZero();
  if (k == 0) return;
  std::array<double, 2> sum_m{};
  std::array<int, 2> known{};
  for (int w = 0; w < kWheels; ++w) {
    const auto reference = [&](Eigen::Index column) {
      return std::complex(values_(sensors_ + 2 * w, column), values_(sensors_ + 2 * w + 1, column));
    };
    const auto now = reference(k), before = reference(k - 1);
    angle_(w, k) = angle_(w, k - 1);
    steps_(w, k) = steps_(w, k - 1);
    if (std::norm(now) < kKnownPower || std::norm(before) < kKnownPower) continue;
    const double turned_rad = std::arg(now * std::conj(before));
    angle_(w, k) += turned_rad;
    steps_(w, k) += 1.0;
    sum_m[static_cast<std::size_t>(w % 2)] += turned_rad * car.rolling_radius_m[static_cast<std::size_t>(w)];
    ++known[static_cast<std::size_t>(w % 2)];
  }
  for (std::size_t side = 0; side < 2; ++side) {
    const std::size_t who = known[side] > 0 ? side : 1 - side;
    const double mean_m = known[who] > 0 ? sum_m[who] / known[who] : 0.0;
    rolled_(static_cast<Eigen::Index>(side), k) = rolled_(static_cast<Eigen::Index>(side), k - 1) + mean_m;
  }
  rolled_(2, k) = known[0] + known[1] > 0 ? 1.0 : 0.0;
}

void SampleHistory::find_forces(const TwinCar& car) {
  const Eigen::Index newest = filled_ - 1, k = newest - kHalfRate, oldest = k - kHalfRate;
  if (oldest < 0) return;
  for (int w = 0; w < kWheels; ++w) {
    const double span_s = (steps_(w, newest) - steps_(w, oldest)) / rate_hz_;
    if (span_s == 0.0) continue;  // add() has set no force
    const double omega = (angle_(w, newest) - angle_(w, oldest)) / span_s;
    const std::complex<double> reference(values_(sensors_ + 2 * w, k), values_(sensors_ + 2 * w + 1, k));
    const auto force = car.unbalance_kg_m[static_cast<std::size_t>(w)] * omega * omega * reference;
    drive_(kWheels + w, k) = force.real();
  }
}

SampleHistory::Drive SampleHistory::drive_at(std::int64_t n, double fraction) const {
  return drive_.middleCols<FractionalDelay::kTaps>(column(n) - FractionalDelay::kBefore) *
         delay_.taps(fraction);
}

}  // namespace roadbalance
