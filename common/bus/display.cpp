#include "common/bus/display.hpp"

#include <wire/envelope_t.hpp>
#include <wire/waterfall_t.hpp>

#include "common/bus/fields.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<Envelope> {
  using Wire = wire::envelope_t;
  static void list(auto& field, auto& e, auto& m) {
    field(e.node, m.node, is_node);
    field(e.channel, m.channel, below(kAccelerations));
    field(e.epoch, m.epoch);
    field(e.first, m.first, at_least(0));
    field(e.scans, m.scans, at_least(1));
    field(e.time_ns, m.time_ns);
    field(e.period_ps, m.period_ps);
    field.rows(e.bucket, m.buckets, kMostBuckets, [&](auto& bucket, std::size_t k) {
      field(bucket.least, m.least[k]);
      field(bucket.greatest, m.greatest[k]);
    });
  }
};

template <>
struct Fields<WaterfallRow> {
  using Wire = wire::waterfall_t;
  static void list(auto& field, auto& row, auto& m) {
    field(row.of.wheel, m.wheel, below(kWheels));
    field(row.of.channel.node, m.node, is_node);
    field(row.of.channel.channel, m.channel, below(kAccelerations));
    field(row.time_ns, m.time_ns);
    field(row.state, m.state, up_to(OrderState::kTooMuch));
    field(row.speed_class, m.speed_class, at_least(0));
    field(row.from_m_s, m.from_m_s);
    field(row.to_m_s, m.to_m_s);
    field(row.way_m, m.way_m);
    field(row.blocks, m.blocks);
    field(row.step, m.step);
    field(row.noise_bandwidth, m.noise_bandwidth);
    field.values(row.amplitude, m.lines, m.amplitude);
  }
};

}  // namespace wire_fields

static_assert(sizeof(wire::envelope_t::least) / sizeof(float) == kMostBuckets);
static_assert(sizeof(wire::waterfall_t::amplitude) / sizeof(float) == kMostWaterfallLines);

std::vector<std::uint8_t> encode(const Envelope& message) {
  return wire_fields::encode(message);
}
std::vector<std::uint8_t> encode(const WaterfallRow& message) {
  return wire_fields::encode(message);
}
std::optional<Envelope> decode_envelope(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Envelope>(bytes);
}
std::optional<WaterfallRow> decode_waterfall(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<WaterfallRow>(bytes);
}

}  // namespace roadbalance
