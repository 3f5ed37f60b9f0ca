#include "sim/conditioner.hpp"

#include <algorithm>
#include <cmath>

#include "common/dsp/linear_filter.hpp"

namespace roadbalance::sim {
namespace {

using SourceRow = Eigen::Matrix<double, 1, kSources>;
using Motion3 = Eigen::Matrix<double, 3, kSources>;  ///< sources to acceleration forward, left, up

std::size_t wheel_of(const std::string& mount) {
  return static_cast<std::size_t>(std::find(kWheelNames.begin(), kWheelNames.end(), mount) -
                                  kWheelNames.begin());
}

Motion3 carrier_motion(int wheel) {
  Motion3 motion = Motion3::Zero();
  motion(0, kForwardSource + wheel) = 1.0;
  motion(0, kDriveSource) = 1.0;
  motion(1, kLeftSource + wheel) = 1.0;
  motion(2, kCoordinateSource + kBodyCoordinates + wheel) = 1.0;
  return motion;
}

/// Rigid body: displacement = rotation (roll, pitch, 0) x place, and heave.
Motion3 body_motion(const Eigen::Vector3d& place_m) {
  Motion3 motion = Motion3::Zero();
  motion(0, kCoordinateSource + 2) = place_m.z();
  motion(0, kDriveSource) = 1.0;
  motion(1, kCoordinateSource + 1) = -place_m.z();
  motion.block<1, 3>(2, kCoordinateSource) << 1.0, place_m.y(), -place_m.x();
  return motion;
}

}  // namespace

Conditioner::Conditioner(const Scenario& scenario, std::uint64_t seed, const VehicleConfig& vehicle,
                         const NodeConfig& node, double step_s)
    : wiring_(decltype(wiring_)::Zero()),
      range_(Channels::Constant(INFINITY)),
      noise_(Channels::Zero()),
      counts_per_unit_(Channels::Zero()),
      offset_counts_(Channels::Zero()),
      last_(Channels::Zero()) {
  design_filter(vehicle.filter, step_s);
  state_.fill(Channels::Zero());
  const double noise_before = scenario.sensor.noise_m_s2 / std::sqrt(filter_noise_gain());
  for (int row = 0; row < kAccelerations; ++row) {
    random_.emplace_back(seed, Use::kSensorNoise, static_cast<std::uint64_t>(node.id * kAccelerations + row));
    if (static_cast<std::size_t>(row) >= node.channel.size()) continue;
    const ChannelConfig& channel = node.channel[static_cast<std::size_t>(row)];
    if (channel.role == ChannelRole::kUnused) continue;
    wire(row, channel, scenario.sensor);
    range_(row) = channel.range_m_s2;
    counts_per_unit_(row) = 1.0 / channel.scale_m_s2_per_count;
    offset_counts_(row) = channel.offset_counts;
    if (channel.role == ChannelRole::kAcceleration) noise_(row) = noise_before;
  }
}

void Conditioner::wire(int row, const ChannelConfig& channel, const SensorScenario& sensor) {
  const auto wheel = static_cast<int>(wheel_of(channel.mount));
  if (channel.role == ChannelRole::kRoad) {
    wiring_(row, kRoadSource + wheel) = 1.0;
    return;
  }
  Eigen::Matrix3d coupling = Eigen::Matrix3d::Identity();
  coupling(0, 2) = coupling(1, 2) = sensor.coupling_from_vertical;
  coupling(2, 0) = coupling(2, 1) = sensor.coupling_into_vertical;
  const Motion3 motion = channel.mount == "body" ? body_motion(channel.position_m) : carrier_motion(wheel);
  wiring_.row(row) = channel.direction.transpose() * coupling * motion;
}

void Conditioner::design_filter(const FilterConfig& filter, double step_s) {
  order_ = filter.order;
  const DiscreteFilter discrete =
      discretise_ramp_invariant(butterworth(filter.order, filter.cutoff_hz), step_s);
  transition_.topLeftCorner(order_, order_) = discrete.A;
  before_.head(order_) = discrete.b0.array();
  now_.head(order_) = discrete.b1.array();
}

double Conditioner::filter_noise_gain() const {
  // Energy of the impulse response: the filter settles within 60 / cut-off, far less than a million steps.
  Eigen::VectorXd x = now_.head(order_).matrix();
  double energy = x(0) * x(0);
  x = (transition_.topLeftCorner(order_, order_) * x + before_.head(order_).matrix()).eval();
  for (int i = 0; i < 1'000'000 && x.squaredNorm() > 1e-24; ++i) {
    energy += x(0) * x(0);
    x = (transition_.topLeftCorner(order_, order_) * x).eval();
  }
  return energy;
}

void Conditioner::feed(const SourceVector& sources, std::int64_t step) {
  Channels signal = (wiring_ * sources).array();
  for (int row = 0; row < kAccelerations; ++row) {
    signal(row) += noise_(row) * random_[static_cast<std::size_t>(row)].normal(step);
    if (std::abs(signal(row)) > range_(row)) overload_ |= 1U << row;
  }
  signal = signal.min(range_).max(-range_);

  std::array<Channels, kMaximumOrder> next;
  for (int i = 0; i < order_; ++i) {
    Channels sum = before_(i) * last_ + now_(i) * signal;
    for (int j = 0; j < order_; ++j) sum += transition_(i, j) * state_[static_cast<std::size_t>(j)];
    next[static_cast<std::size_t>(i)] = sum;
  }
  std::copy_n(next.begin(), order_, state_.begin());
  last_ = signal;
}

void Conditioner::convert(Scan& scan) {
  const Channels counts = (state_[0] * counts_per_unit_ + offset_counts_).round();
  for (int row = 0; row < kAccelerations; ++row) {
    constexpr double kLowest = -static_cast<double>(kFullScaleCounts);
    constexpr double kHighest = static_cast<double>(kFullScaleCounts) - 1.0;
    if (counts(row) < kLowest || counts(row) > kHighest) overload_ |= 1U << row;
    scan.counts[static_cast<std::size_t>(row)] =
        static_cast<std::int32_t>(std::clamp(counts(row), kLowest, kHighest));
  }
  scan.overload = overload_;
  overload_ = 0;
}

}  // namespace roadbalance::sim
