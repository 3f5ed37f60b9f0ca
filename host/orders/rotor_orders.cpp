#include "host/orders/rotor_orders.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "common/dsp/decimation.hpp"
#include "host/orders/anti_aliasing.hpp"

namespace roadbalance {
namespace {

/// Of the sampling rate: so far FractionalDelay is a pure delay.
constexpr double kInterpolated = 0.38;
constexpr double kLeastReference = 0.5;  // of full scale; a known angle has nearly 1
constexpr double kTurn = 2.0 * std::numbers::pi;

double highest_hz(const VehicleConfig& vehicle, const NodeConfig& node) {
  return std::min(kInterpolated * node.rate_hz, AntiAliasing(vehicle.filter).flat_to_hz());
}

OrderVectors::Settings vector_settings(const VehicleConfig& vehicle, const Rotor& rotor,
                                       const NodeConfig& node, int channels,
                                       const std::vector<double>& order) {
  // Order h of the rotor is order ratio h of the wheels, whose angle has passed the filter.
  return {channels,
          RotorOrders::kRowsPerTurn,
          RotorOrders::kVectorTurns,
          order,
          highest_hz(vehicle, node),
          rotor.class_hz(vehicle),
          [filter = AntiAliasing(vehicle.filter), ratio = rotor.ratio](double h, double rotation_hz) {
            return filter.on_order(h * ratio, rotation_hz / ratio);
          },
          rotor.known_share};
}

/// The node of the channels first, then those that read the encoders.
std::vector<const NodeConfig*> nodes_of(const VehicleConfig& vehicle, const Rotor& rotor, int node) {
  std::vector<const NodeConfig*> nodes{&vehicle.node[static_cast<std::size_t>(node)]};
  for (const int w : rotor.wheel) {
    const NodeConfig* const reads = &vehicle.node_named(vehicle.wheel[static_cast<std::size_t>(w)].node);
    if (std::ranges::find(nodes, reads) == nodes.end()) nodes.push_back(reads);
  }
  return nodes;
}

}  // namespace

RotorOrders::RotorOrders(const VehicleConfig& vehicle, Rotor rotor, int node,
                         std::vector<std::size_t> channel, std::vector<double> order, const Effort& effort)
    : rotor_(std::move(rotor)),
      node_(vehicle.node[static_cast<std::size_t>(node)]),
      channel_(std::move(channel)),
      order_(std::move(order)),
      way_m_(rotor_.way_m(vehicle)),
      effort_(effort),
      waterfall_({static_cast<int>(channel_.size()), kRowsPerTurn, kSpectrumTurns,
                  kDecimationFlatTo * kRowsPerTurn, highest_hz(vehicle, node_), rotor_.class_hz(vehicle)}),
      vectors_(vector_settings(vehicle, rotor_, node_, static_cast<int>(channel_.size()), order_)),
      spectrum_blocks_({static_cast<int>(channel_.size()), kRowsPerTurn, kSpectrumTurns, kSpectrumTurns / 4},
                       [this](const TurnBlock& block) { waterfall_.add(block); }),
      vector_blocks_({static_cast<int>(channel_.size()), kRowsPerTurn, kVectorTurns, kVectorTurns},
                     [this](const TurnBlock& block) { vectors_.add(block); }),
      resampler_({static_cast<int>(channel_.size()), node_.rate_hz, kRowsPerTurn,
                  effort_.least_rotation_hz * rotor_.ratio},
                 [this](const AngleRow& row) {
                   if (effort_.spectra) spectrum_blocks_.add(row);
                   vector_blocks_.add(row);
                 }),
      values_(std::ssize(channel_)),
      join_(
          nodes_of(vehicle, rotor_, node), [this](const GridJoin::Row& row) { take(row); },
          effort.longest_wait_s) {
  const auto nodes = nodes_of(vehicle, rotor_, node);
  for (const int w : rotor_.wheel) {
    const WheelConfig& wheel = vehicle.wheel[static_cast<std::size_t>(w)];
    const auto at = std::ranges::find(nodes, &vehicle.node_named(wheel.node)) - nodes.begin();
    wheel_.push_back({static_cast<std::size_t>(at), wheel.line});
  }
}

void RotorOrders::take(const GridJoin::Row& row) {
  if (row.restart) {
    if (rows_ > 0) ++gaps_;
    resampler_.interrupt();
    forget_turns();
  }
  ++rows_;
  const GridJoin::Sample& sample = row.sample.front();
  std::uint32_t overload = 0;
  for (std::size_t c = 0; c < channel_.size(); ++c) {
    overload |= static_cast<std::uint32_t>(sample.overload >> channel_[c] & 1) << c;
    values_(static_cast<Eigen::Index>(c)) =
        node_.channel[channel_[c]].to_si(static_cast<double>((*sample.counts)[channel_[c]]));
  }
  const auto angle_rad = angle(row);
  if (!angle_rad) forget_turns();
  resampler_.add(angle_rad, values_, overload);
}

void RotorOrders::forget_turns() {
  for (Wheel& wheel : wheel_) wheel.angle_rad.reset();
}

std::optional<double> RotorOrders::angle(const GridJoin::Row& row) {
  double sum = 0.0;
  bool uncertain = false;
  for (Wheel& wheel : wheel_) {
    const GridJoin::Sample& sample = row.sample[wheel.node];
    const auto sine = static_cast<std::size_t>(kAccelerations + 2 * wheel.line);
    const std::complex<double> reference((*sample.counts)[sine + 1], (*sample.counts)[sine]);
    if ((sample.quality & quality_no_reference(wheel.line)) != 0 ||
        std::abs(reference) < kLeastReference * kFullScaleCounts) {
      ++no_angle_;
      return std::nullopt;
    }
    const std::int32_t doubt = wheel.line == 0 ? kQualityUncertainAngle0 : kQualityUncertainAngle1;
    uncertain = uncertain || (sample.quality & doubt) != 0;
    const double now = std::arg(reference);
    wheel.angle_rad =
        wheel.angle_rad ? *wheel.angle_rad + std::remainder(now - *wheel.angle_rad, kTurn) : now;
    sum += *wheel.angle_rad;
  }
  if (uncertain) {
    ++uncertain_;
    return std::nullopt;
  }
  return rotor_.ratio * sum / static_cast<double>(wheel_.size());
}

RotorOrders::Seconds RotorOrders::seconds() const {
  const auto seconds = [&](std::int64_t rows) { return static_cast<double>(rows) / node_.rate_hz; };
  return {seconds(rows_), seconds(no_angle_), seconds(uncertain_), seconds(resampler_.slow_samples())};
}

}  // namespace roadbalance
