#include "host/analyser/live_orders.hpp"

#include <algorithm>
#include <utility>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

constexpr RotorOrders::Effort kOrderEffort{.spectra = false,
                                           .least_rotation_hz = LiveOrders::kLeastRotation_hz,
                                           .highest_hz = LiveOrders::kHighest_hz,
                                           .longest_wait_s = 60.0};

OrderReport::Vector vector_of(const MeanVector& mean) {
  OrderReport::Vector vector;
  vector.value = mean.mean();
  vector.blocks = mean.count();
  const auto confidence = mean.confidence();
  if (!confidence) return vector;
  vector.amplitude_95 = confidence->amplitude;
  if (confidence->phase_rad) vector.phase_95_rad = *confidence->phase_rad;
  return vector;
}

}  // namespace

LiveOrders::LiveOrders(const VehicleConfig& vehicle) {
  for (int w = 0; w < kWheels; ++w) {
    const WheelConfig& wheel = vehicle.wheel[static_cast<std::size_t>(w)];
    if (wheel.node.empty()) continue;
    for (std::size_t n = 0; n < vehicle.node.size(); ++n) {
      std::vector<std::size_t> channels;
      for (std::size_t c = 0; c < vehicle.node[n].channel.size(); ++c)
        if (vehicle.node[n].channel[c].role == ChannelRole::kAcceleration) channels.push_back(c);
      if (channels.empty()) continue;
      add({w,
           std::make_unique<RotorOrders>(vehicle, rotor_of(vehicle, wheel), static_cast<int>(n),
                                         std::move(channels), std::vector<double>{1.0, 2.0}, kOrderEffort)});
    }
  }
}

void LiveOrders::add(One one) {
  const auto shares = [&](const RotorOrders* each) { return each->can_share_with(*one.orders); };
  const auto found = std::ranges::find_if(consuming_, shares);
  if (found == consuming_.end())
    consuming_.push_back(one.orders.get());
  else
    (*found)->share_with(*one.orders);
  all_.push_back(std::move(one));
}

void LiveOrders::consume(const SealedBlock& block) {
  if (block.kind != BlockKind::kScan || consuming_.empty()) return;
  const ScanBlock scans = decode_scan(block);  // once: several are of each node
  for (RotorOrders* const orders : consuming_) orders->consume(scans);
  for (One& one : all_)
    if (block.header.node == one.orders->node().id) one.time_ns = block.header.time_ns;
}

void LiveOrders::consume(const ClockFit& fit) {
  for (RotorOrders* const orders : consuming_) orders->consume(fit);
}

std::vector<OrderReport> LiveOrders::reports() const {
  std::vector<OrderReport> reports;
  for (const One& one : all_) {
    const RotorOrders& orders = *one.orders;
    if (!(orders.seconds().recorded > 0.0)) continue;
    OrderReport& report = reports.emplace_back();
    report.wheel = one.wheel;
    report.node = orders.node().id;
    report.time_ns = one.time_ns;
    report.seconds = orders.seconds().recorded;
    report.no_angle_s = orders.seconds().no_angle;
    for (std::size_t h = 0; h < OrderReport::kOrders; ++h)
      for (std::size_t c = 0; c < orders.channel().size(); ++c)
        report.order[h][orders.channel()[c]] = vector_of(orders.vectors().result(static_cast<int>(c), h).all);
  }
  return reports;
}

}  // namespace roadbalance
