#include "sim/conditioner.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

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

/// What the counters of a channel's faults draw.
enum Fault : std::int64_t { kTilt, kTiltDirection, kGain, kBracket, kMountingNoise };

/// `direction`, tilted by an angle up to `most_rad`.
Eigen::Vector3d tilted(const Eigen::Vector3d& direction, double most_rad, const RandomSequence& random) {
  if (most_rad == 0.0) return direction;
  const double angle_rad = random.between(kTilt, 0.0, most_rad);
  const double towards_rad = random.between(kTiltDirection, 0.0, 2.0 * std::numbers::pi);
  const Eigen::Vector3d across = direction.unitOrthogonal();
  const Eigen::Vector3d side =
      std::cos(towards_rad) * across + std::sin(towards_rad) * direction.normalized().cross(across);
  return std::cos(angle_rad) * direction + std::sin(angle_rad) * direction.norm() * side;
}

/// A Butterworth filter of components with a tolerance: corner and damping of each pair of poles, and a
/// single pole, are off by up to `tolerance`.
ContinuousFilter toleranced(const FilterConfig& filter, double tolerance, const RandomSequence& random) {
  if (tolerance == 0.0) return butterworth(filter.order, filter.cutoff_hz);
  Eigen::VectorXd denominator = Eigen::VectorXd::Ones(1);
  const auto multiply = [&](const Eigen::VectorXd& factor) {
    Eigen::VectorXd product = Eigen::VectorXd::Zero(denominator.size() + factor.size() - 1);
    for (Eigen::Index i = 0; i < factor.size(); ++i)
      product.segment(i, denominator.size()) += factor(i) * denominator;
    denominator = product;
  };
  const auto off = [&](int counter) { return random.between(counter, 1.0 - tolerance, 1.0 + tolerance); };
  for (int pair = 0; pair < filter.order / 2; ++pair) {
    const double corner = off(2 * pair);
    const double damping =
        std::sin((2 * pair + 1) * std::numbers::pi / (2 * filter.order)) * off(2 * pair + 1);
    multiply(Eigen::Vector3d(corner * corner, 2.0 * damping * corner, 1.0));
  }
  if (filter.order % 2 == 1) multiply(Eigen::Vector2d(off(filter.order), 1.0));
  ContinuousFilter toleranced = companion(denominator.head(filter.order));
  const double corner_rad_s = 2.0 * std::numbers::pi * filter.cutoff_hz;
  toleranced.F *= corner_rad_s;
  toleranced.G *= corner_rad_s * denominator(0);  // 1 at rest
  return toleranced;
}

/// Energy of the impulse response.
double noise_gain(const DiscreteFilter& filter) {
  // The filter settles within 60 / cut-off, far less than a million steps.
  Eigen::VectorXd x = filter.b1;
  double energy = x(0) * x(0);
  x = (filter.A * x + filter.b0).eval();
  for (int i = 0; i < 1'000'000 && x.squaredNorm() > 1e-24; ++i) {
    energy += x(0) * x(0);
    x = (filter.A * x).eval();
  }
  return energy;
}

}  // namespace

Conditioner::Conditioner(const Scenario& scenario, std::uint64_t seed, const VehicleConfig& vehicle,
                         const NodeConfig& node, double step_s)
    : wiring_(decltype(wiring_)::Zero()),
      range_(Channels::Constant(INFINITY)),
      clips_at_(Channels::Constant(INFINITY)),
      noise_(Channels::Zero()),
      counts_per_unit_(Channels::Zero()),
      offset_counts_(Channels::Zero()),
      order_(vehicle.filter.order),
      last_(Channels::Zero()) {
  const SensorScenario& sensor = scenario.sensor;
  const DiscreteFilter nominal =
      discretise_ramp_invariant(butterworth(order_, vehicle.filter.cutoff_hz), step_s);
  state_.fill(Channels::Zero());
  const double noise_behind = std::sqrt(noise_gain(nominal));
  for (int row = 0; row < kAccelerations; ++row) {
    const auto which = static_cast<std::uint64_t>(node.id * kAccelerations + row);
    random_.emplace_back(seed, Use::kSensorNoise, which);
    set_filter(row, nominal);
    if (static_cast<std::size_t>(row) >= node.channel.size()) continue;
    const ChannelConfig& channel = node.channel[static_cast<std::size_t>(row)];
    if (channel.role == ChannelRole::kUnused) continue;
    const RandomSequence fault(seed, Use::kSensorFault, which);
    wire(row, channel, sensor, fault);
    range_(row) = clips_at_(row) = channel.range_m_s2;
    counts_per_unit_(row) = 1.0 / channel.scale_m_s2_per_count;
    offset_counts_(row) = channel.offset_counts;
    if (channel.role != ChannelRole::kAcceleration) continue;
    const double mounting_m_s2 =
        fault.between(kMountingNoise, sensor.mounting_noise_m_s2.low, sensor.mounting_noise_m_s2.high);
    noise_(row) = std::hypot(sensor.noise_m_s2, mounting_m_s2) / noise_behind;
    clips_at_(row) *= sensor.clips_at;
    if (sensor.bracket_hz.high > 0.0)
      put_on_bracket(row, fault.between(kBracket, sensor.bracket_hz.low, sensor.bracket_hz.high),
                     sensor.bracket_damping, step_s);
    const RandomSequence components(seed, Use::kFilterFault, which);
    set_filter(row, discretise_ramp_invariant(toleranced(vehicle.filter, sensor.filter, components), step_s));
  }
}

void Conditioner::wire(int row, const ChannelConfig& channel, const SensorScenario& sensor,
                       const RandomSequence& random) {
  const auto wheel = static_cast<int>(wheel_of(channel.mount));
  if (channel.role == ChannelRole::kRoad) {
    wiring_(row, kRoadSource + wheel) = 1.0;
    return;
  }
  Eigen::Matrix3d coupling = Eigen::Matrix3d::Identity();
  coupling(0, 2) = coupling(1, 2) = sensor.coupling_from_vertical;
  coupling(2, 0) = coupling(2, 1) = sensor.coupling_into_vertical;
  const Motion3 motion = channel.mount == "body" ? body_motion(channel.position_m) : carrier_motion(wheel);
  const double gain = random.between(kGain, 1.0 - sensor.gain, 1.0 + sensor.gain);
  wiring_.row(row) =
      gain * tilted(channel.direction, sensor.tilt_rad, random).transpose() * coupling * motion;
}

void Conditioner::put_on_bracket(int row, double frequency_hz, double damping, double step_s) {
  if (!brackets_) {
    brackets_.emplace();
    for (auto* const pair : {&brackets_->before, &brackets_->now, &brackets_->out, &brackets_->state})
      pair->fill(Channels::Zero());
    for (auto& from : brackets_->transition) from.fill(Channels::Zero());
    brackets_->through = Channels::Ones();
    brackets_->last = Channels::Zero();
  }
  Brackets& b = *brackets_;
  const double corner = 2.0 * std::numbers::pi * frequency_hz;
  const Eigen::Vector2d denominator(corner * corner, 2.0 * damping * corner);
  const DiscreteFilter filter = discretise_ramp_invariant(companion(denominator), step_s);
  b.through(row) = 0.0;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    for (std::size_t j = 0; j < 2; ++j) b.transition[i][j](row) = filter.A(at, static_cast<Eigen::Index>(j));
    b.before[i](row) = filter.b0(at);
    b.now[i](row) = filter.b1(at);
    b.out[i](row) = denominator(at);
  }
}

void Conditioner::set_filter(int row, const DiscreteFilter& filter) {
  for (int i = 0; i < order_; ++i) {
    const auto to = static_cast<std::size_t>(i);
    for (int j = 0; j < order_; ++j) transition_[to][static_cast<std::size_t>(j)](row) = filter.A(i, j);
    before_[to](row) = filter.b0(i);
    now_[to](row) = filter.b1(i);
  }
}

/// The part of each channel's bracket of how the car moves: (2 D w s + w^2) / (s^2 + 2 D w s + w^2).
Conditioner::Channels Conditioner::behind_brackets(const Channels& moved) {
  Brackets& b = *brackets_;
  std::array<Channels, 2> next;
  for (std::size_t i = 0; i < 2; ++i)
    next[i] = b.transition[i][0] * b.state[0] + b.transition[i][1] * b.state[1] + b.before[i] * b.last +
              b.now[i] * moved;
  b.state = next;
  b.last = moved;
  return b.through * moved + b.out[0] * b.state[0] + b.out[1] * b.state[1];
}

void Conditioner::feed(const SourceVector& sources, std::int64_t step) {
  Channels signal = (wiring_ * sources).array();
  if (brackets_) signal = behind_brackets(signal);
  for (int row = 0; row < kAccelerations; ++row) {
    signal(row) += noise_(row) * random_[static_cast<std::size_t>(row)].normal(step);
    if (std::abs(signal(row)) > range_(row)) overload_ |= 1U << row;
  }
  signal = signal.min(clips_at_).max(-clips_at_);

  std::array<Channels, kMaximumOrder> next;
  const auto order = static_cast<std::size_t>(order_);
  for (std::size_t i = 0; i < order; ++i) {
    Channels sum = before_[i] * last_ + now_[i] * signal;
    for (std::size_t j = 0; j < order; ++j) sum += transition_[i][j] * state_[j];
    next[i] = sum;
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
