#include "host/analysis/orders/rotor_orders.hpp"

#include <algorithm>
#include <cassert>
#include <span>
#include <utility>

#include "common/dsp/decimation.hpp"
#include "host/analysis/orders/anti_aliasing.hpp"

namespace roadbalance {
namespace {

/// Share of the sampling rate up to which FractionalDelay is a pure delay.
constexpr double kInterpolated = 0.38;

double highest_hz(const VehicleConfig& vehicle, const NodeConfig& node) {
  return std::min(kInterpolated * node.rate_hz, AntiAliasing(vehicle.filter).flat_to_hz());
}

OrderVectors::Settings vector_settings(const VehicleConfig& vehicle, const Rotor& rotor,
                                       const NodeConfig& node, int channels, const std::vector<double>& order,
                                       int turns) {
  // Order h of the rotor is order ratio h of the wheels, whose angle has passed the filter.
  return {channels,
          RotorOrders::kRowsPerTurn,
          turns,
          order,
          highest_hz(vehicle, node),
          rotor.class_hz(vehicle),
          [filter = AntiAliasing(vehicle.filter), ratio = rotor.ratio](double h, double rotation_hz) {
            return filter.on_order(h * ratio, rotation_hz / ratio);
          },
          rotor.known_share};
}

int decimation_for(const RotorOrders::Effort& effort, const NodeConfig& node) {
  if (!(effort.highest_hz > 0.0)) return 1;
  return std::max(1, static_cast<int>(kDecimationFlatTo * node.rate_hz / effort.highest_hz));
}

std::vector<std::int32_t> numbers_of(const std::vector<const NodeConfig*>& nodes) {
  std::vector<std::int32_t> numbers;
  for (const NodeConfig* const node : nodes) numbers.push_back(node->id);
  return numbers;
}

}  // namespace

RotorOrders::RotorOrders(const VehicleConfig& vehicle, Rotor rotor, int node,
                         std::vector<std::size_t> channel, std::vector<double> order, const Effort& effort)
    : rotor_(std::move(rotor)),
      node_(vehicle.node[static_cast<std::size_t>(node)]),
      joined_(numbers_of(nodes_of(vehicle, {&rotor_, 1}, node))),
      channel_(std::move(channel)),
      order_(std::move(order)),
      way_m_(rotor_.way_m(vehicle)),
      effort_(effort),
      angle_(vehicle, rotor_, nodes_of(vehicle, {&rotor_, 1}, node)),
      waterfall_({static_cast<int>(channel_.size()), kRowsPerTurn, kSpectrumTurns,
                  kDecimationFlatTo * kRowsPerTurn, highest_hz(vehicle, node_), rotor_.class_hz(vehicle)}),
      vectors_(vector_settings(vehicle, rotor_, node_, static_cast<int>(channel_.size()), order_,
                               effort_.vector_turns)),
      spectrum_blocks_({static_cast<int>(channel_.size()), kRowsPerTurn, kSpectrumTurns, kSpectrumTurns / 4},
                       [this](const TurnBlock& block) { waterfall_.add(block); }),
      vector_blocks_(
          {static_cast<int>(channel_.size()), kRowsPerTurn, effort_.vector_turns, effort_.vector_turns},
          [this](const TurnBlock& block) {
            stretch_ = {stretch_ ? stretch_->from_s : block.from_s, block.to_s};
            vectors_.add(block);
          }),
      factor_(decimation_for(effort_, node_)),
      resampler_({static_cast<int>(channel_.size()), node_.rate_hz / factor_, kRowsPerTurn,
                  effort_.least_rotation_hz * rotor_.ratio},
                 [this](const AngleRow& row) {
                   if (effort_.spectra) spectrum_blocks_.add(row);
                   vector_blocks_.add(row);
                 }),
      fewer_(static_cast<int>(channel_.size()), factor_,
             [this](std::span<const FewerSamples::Angle> angle_rad,
                    const Eigen::Ref<const Eigen::VectorXd>& values, std::uint32_t overload) {
               for (std::size_t k = 0; k < sharing_.size(); ++k)
                 sharing_[k]->resampler_.add(angle_rad[k], values, overload);
             }),
      si_(node_, channel_),
      values_(si_.size()),
      join_(
          nodes_of(vehicle, {&rotor_, 1}, node), [this](const GridJoin::Row& row) { take(row); },
          effort.longest_wait_s) {}

bool RotorOrders::can_share_with(const RotorOrders& other) const {
  return joined_ == other.joined_ && channel_ == other.channel_ && effort_ == other.effort_;
}

void RotorOrders::share_with(RotorOrders& other) {
  assert(can_share_with(other));
  sharing_.push_back(&other);
  fewer_.follow(sharing_.size());
}

void RotorOrders::restart() {
  if (rows_ > 0) ++gaps_;
  resampler_.interrupt();
  angle_.forget();
}

void RotorOrders::take(const GridJoin::Row& row) {
  if (row.restart) {
    fewer_.interrupt();
    for (RotorOrders* const each : sharing_) each->restart();
  }
  const std::uint32_t overload = si_.read(row.sample.front(), values_);
  for (std::size_t k = 0; k < sharing_.size(); ++k) sharing_[k]->give_angle(row, fewer_, k);
  fewer_.add(values_, overload);
}

void RotorOrders::give_angle(const GridJoin::Row& row, FewerSamples& fewer, std::size_t which) {
  ++rows_;
  RotorAngle::State state = angle_.state(row);
  std::int64_t rows = 1;
  if (state == RotorAngle::State::kKnown) {
    if (!fewer.wants_angle()) return;
    const RotorAngle::Reading reading = angle_.read(row);
    if (reading.state == RotorAngle::State::kKnown) return fewer.set_angle(which, reading.angle_rad);
    state = reading.state;
    rows = factor_;
  }
  (state == RotorAngle::State::kNotKnown ? no_angle_ : uncertain_) += rows;
  fewer.lose_angle(which);
  angle_.forget();
}

RotorOrders::Seconds RotorOrders::seconds() const {
  const auto seconds = [&](std::int64_t rows) { return static_cast<double>(rows) / node_.rate_hz; };
  return {seconds(rows_), seconds(no_angle_), seconds(uncertain_),
          seconds(factor_ * resampler_.slow_samples())};
}

}  // namespace roadbalance
