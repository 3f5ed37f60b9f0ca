#include "host/analyser/waterfall_view.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace roadbalance {
namespace {

constexpr RotorOrders::Effort kWaterfallEffort{.spectra = true,
                                               .least_rotation_hz = WaterfallView::kLeastRotation_hz};

void add_rows(const WaterfallRow& about, const RotorOrders& orders, double class_hz,
              std::vector<WaterfallRow>& rows) {
  for (const OrderWaterfall::Row& from : orders.waterfall().rows(0)) {
    WaterfallRow& row = rows.emplace_back(about);
    row.speed_class = static_cast<std::int32_t>(std::lround(from.from_hz / class_hz));
    row.from_m_s = from.from_hz * orders.way_m();
    row.to_m_s = from.to_hz * orders.way_m();
    row.way_m = orders.way_m();
    row.step = from.spectrum.step;
    row.noise_bandwidth = from.spectrum.noise_bandwidth;
    row.blocks = from.spectrum.averages.empty() ? 0 : from.spectrum.averages.front();
    const std::size_t lines = std::min(from.spectrum.amplitude.size(), kMostWaterfallLines);
    for (std::size_t k = 0; k < lines; ++k)
      row.amplitude.push_back(static_cast<float>(from.spectrum.amplitude[k]));
  }
}

}  // namespace

WaterfallView::Wanted WaterfallView::begin(const WheelChannel& of) {
  const NodeConfig* const node = vehicle_.node_with_id(of.channel.node);
  const WheelConfig& wheel = vehicle_.wheel[static_cast<std::size_t>(of.wheel)];
  const auto channel = static_cast<std::size_t>(of.channel.channel);
  if (!node || wheel.node.empty() || channel >= node->channel.size() ||
      node->channel[channel].role != ChannelRole::kAcceleration)
    return {.heard = {}, .state = OrderState::kNoChannel};
  const auto begun =
      std::ranges::count_if(wanted_, [](const auto& one) { return one.second.orders != nullptr; });
  if (begun >= static_cast<std::ptrdiff_t>(kMostWaterfalls))
    return {.heard = {}, .state = OrderState::kTooMuch};
  Wanted wanted{.heard = {}};
  wanted.orders = std::make_unique<RotorOrders>(
      vehicle_, rotor_of(vehicle_, wheel), static_cast<int>(node - vehicle_.node.data()),
      std::vector<std::size_t>{channel}, std::vector<double>{1.0}, kWaterfallEffort);
  for (const auto& [id, fit] : newest_fit_) wanted.orders->consume(fit);
  return wanted;
}

void WaterfallView::take(const View& view, WallTime now) {
  forget(now);
  for (const WheelChannel& of : view.waterfall) {
    auto found = wanted_.find(of);
    if (found == wanted_.end() && wanted_.size() >= 4 * kMostWaterfalls) continue;
    if (found == wanted_.end() || found->second.state == OrderState::kTooMuch)  // others may have left
      found = wanted_.insert_or_assign(of, begin(of)).first;
    found->second.heard = now;
  }
}

void WaterfallView::forget(WallTime now) {
  std::erase_if(wanted_, [&](const auto& one) { return now - one.second.heard > kForgotten; });
}

void WaterfallView::consume(const SealedBlock& block) {
  for (auto& [of, wanted] : wanted_) {
    if (!wanted.orders) continue;
    wanted.orders->consume(block);
    if (block.kind == BlockKind::kScan && block.header.node == of.channel.node)
      wanted.time_ns = block.header.time_ns;
  }
}

void WaterfallView::consume(const ClockFit& fit) {
  if (!vehicle_.node_with_id(fit.node)) return;
  newest_fit_.insert_or_assign(fit.node, fit);
  for (auto& [of, wanted] : wanted_)
    if (wanted.orders) wanted.orders->consume(fit);
}

std::vector<WaterfallRow> WaterfallView::rows(WallTime now) {
  forget(now);
  std::vector<WaterfallRow> rows;
  for (const auto& [of, wanted] : wanted_) {
    const WaterfallRow about{.of = of, .time_ns = wanted.time_ns, .state = wanted.state};
    const std::size_t before = rows.size();
    if (wanted.orders) add_rows(about, *wanted.orders, wanted.orders->rotor().class_hz(vehicle_), rows);
    if (rows.size() > before) continue;
    rows.push_back(about);
    if (wanted.orders) rows.back().state = OrderState::kTooShort;
  }
  return rows;
}

}  // namespace roadbalance
