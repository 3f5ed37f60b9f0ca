#include "common/bus/display.hpp"

#include <algorithm>
#include <cassert>
#include <wire/envelope_t.hpp>
#include <wire/waterfall_t.hpp>

#include "common/bus/node_number.hpp"
#include "common/bus/wire_format.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {
namespace {

static_assert(sizeof(wire::envelope_t::least) / sizeof(float) == kMostBuckets);
static_assert(sizeof(wire::waterfall_t::amplitude) / sizeof(float) == kMostWaterfallLines);

bool is_acceleration(std::int32_t channel) {
  return 0 <= channel && channel < kAccelerations;
}

}  // namespace

std::vector<std::uint8_t> encode(const Envelope& e) {
  assert(e.bucket.size() <= kMostBuckets);
  wire::envelope_t m{};
  m.node = e.node;
  m.channel = e.channel;
  m.epoch = e.epoch;
  m.first = e.first;
  m.scans = e.scans;
  m.time_ns = e.time_ns;
  m.period_ps = e.period_ps;
  m.buckets = static_cast<std::int32_t>(e.bucket.size());
  for (std::size_t k = 0; k < e.bucket.size(); ++k) {
    m.least[k] = e.bucket[k].least;
    m.greatest[k] = e.bucket[k].greatest;
  }
  return wire_format::encode(m);
}

std::optional<Envelope> decode_envelope(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::envelope_t>(bytes);
  if (!m || !is_node(m->node) || !is_acceleration(m->channel) || m->first < 0 || m->scans < 1 ||
      m->buckets < 0 || m->buckets > static_cast<std::int32_t>(kMostBuckets))
    return std::nullopt;
  Envelope e{.node = m->node,
             .channel = m->channel,
             .epoch = m->epoch,
             .first = m->first,
             .scans = m->scans,
             .time_ns = m->time_ns,
             .period_ps = m->period_ps};
  for (std::int32_t k = 0; k < m->buckets; ++k) e.bucket.push_back({m->least[k], m->greatest[k]});
  return e;
}

std::vector<std::uint8_t> encode(const WaterfallRow& row) {
  assert(row.amplitude.size() <= kMostWaterfallLines);
  wire::waterfall_t m{};
  m.wheel = row.of.wheel;
  m.node = row.of.channel.node;
  m.channel = row.of.channel.channel;
  m.time_ns = row.time_ns;
  m.state = static_cast<std::int32_t>(row.state);
  m.speed_class = row.speed_class;
  m.from_m_s = row.from_m_s;
  m.to_m_s = row.to_m_s;
  m.way_m = row.way_m;
  m.blocks = row.blocks;
  m.step = row.step;
  m.noise_bandwidth = row.noise_bandwidth;
  m.lines = static_cast<std::int32_t>(row.amplitude.size());
  std::ranges::copy(row.amplitude, m.amplitude);
  return wire_format::encode(m);
}

std::optional<WaterfallRow> decode_waterfall(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::waterfall_t>(bytes);
  if (!m || m->wheel < 0 || m->wheel >= kWheels || !is_node(m->node) || !is_acceleration(m->channel) ||
      m->state < 0 || m->state > static_cast<std::int32_t>(OrderState::kTooMuch) || m->speed_class < 0 ||
      m->lines < 0 || m->lines > static_cast<std::int32_t>(kMostWaterfallLines))
    return std::nullopt;
  return WaterfallRow{.of = {m->wheel, {m->node, m->channel}},
                      .time_ns = m->time_ns,
                      .state = static_cast<OrderState>(m->state),
                      .speed_class = m->speed_class,
                      .from_m_s = m->from_m_s,
                      .to_m_s = m->to_m_s,
                      .way_m = m->way_m,
                      .blocks = m->blocks,
                      .step = m->step,
                      .noise_bandwidth = m->noise_bandwidth,
                      .amplitude = {m->amplitude, m->amplitude + m->lines}};
}

}  // namespace roadbalance
