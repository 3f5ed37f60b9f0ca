#include "common/bus/setup.hpp"

#include <algorithm>
#include <cassert>
#include <string_view>
#include <wire/setup_t.hpp>

#include "common/bus/node_number.hpp"
#include "common/bus/wire_format.hpp"
#include "common/bus/wire_text.hpp"
#include "common/link/text_crc.hpp"

namespace roadbalance {
namespace {

static_assert(sizeof(wire::setup_t::role) / sizeof(std::int32_t) == kAccelerations);
static_assert(sizeof(wire::setup_t::wheel) / sizeof(std::int32_t) == kEncoderLines);

std::int32_t place_of_wheel(const std::string& name) {
  const auto found =
      std::ranges::find(kWheelNames, name, [](const char* each) { return std::string_view(each); });
  return found == kWheelNames.end() ? -1 : static_cast<std::int32_t>(found - kWheelNames.begin());
}

std::array<float, 3> floats(const Eigen::Vector3d& vector) {
  const Eigen::Vector3f narrow = vector.cast<float>();
  return {narrow.x(), narrow.y(), narrow.z()};
}

NodeSetup::Channel channel_of(const ChannelConfig& config) {
  return {.name = config.name,
          .role = config.role,
          .mount = place_of_wheel(config.mount),
          .position_m = floats(config.position_m),
          .direction = floats(config.direction),
          .range_m_s2 = static_cast<float>(config.range_m_s2),
          .scale_m_s2_per_count = static_cast<float>(config.scale_m_s2_per_count),
          .offset_counts = static_cast<float>(config.offset_counts),
          .delay_s = static_cast<float>(config.delay_s)};
}

NodeSetup::Encoder encoder_of(const EncoderConfig& config, int wheel) {
  const auto trait = [](bool has, EncoderTrait one) { return has ? static_cast<std::int32_t>(one) : 0; };
  return {.wheel = wheel,
          .pulses_per_turn = config.pulses_per_turn,
          .traits = trait(config.zero_mark, EncoderTrait::kZeroMark) |
                    trait(config.quadrature, EncoderTrait::kQuadrature) |
                    trait(!config.counter.empty(), EncoderTrait::kCountedOnBus),
          .datum_rad = config.datum_rad,
          .datum_sigma_rad = config.datum_sigma_rad};
}

bool in_bounds(const wire::setup_t& m) {
  if (!is_node(m.node) || m.channels < 0 || m.channels > kAccelerations) return false;
  const auto is_wheel_or_none = [](std::int32_t wheel) { return -1 <= wheel && wheel < kWheels; };
  return std::all_of(m.role, m.role + m.channels,
                     [](std::int32_t role) {
                       return 0 <= role && role <= static_cast<std::int32_t>(ChannelRole::kUnused);
                     }) &&
         std::all_of(m.mount, m.mount + m.channels, is_wheel_or_none) &&
         std::all_of(m.wheel, m.wheel + kEncoderLines, is_wheel_or_none);
}

}  // namespace

std::string setup_channel(std::int32_t node) {
  return "RB_SETUP_" + std::to_string(node);
}

NodeSetup setup_of(const VehicleConfig& vehicle, const NodeConfig& node) {
  const std::string_view text = vehicle.text;
  NodeSetup setup{.node = node.id,
                  .name = node.name,
                  .vehicle = vehicle.name,
                  .vehicle_crc32c = crc32c(text),
                  .rate_hz = node.rate_hz,
                  .filter_order = vehicle.filter.order,
                  .filter_cutoff_hz = vehicle.filter.cutoff_hz,
                  .channel = {},
                  .encoder = {}};
  for (const ChannelConfig& channel : node.channel) setup.channel.push_back(channel_of(channel));
  for (int line = 0; line < kEncoderLines; ++line)
    if (const WheelConfig* const wheel = vehicle.wheel_at(node, line))
      setup.encoder[static_cast<std::size_t>(line)] = encoder_of(wheel->encoder, vehicle.place_of(*wheel));
  return setup;
}

std::vector<std::uint8_t> encode(const NodeSetup& s) {
  assert(s.channel.size() <= kAccelerations);
  wire::setup_t m{};
  m.node = s.node;
  wire_text::put_text(s.name, m.name);
  wire_text::put_text(s.vehicle, m.vehicle);
  m.vehicle_crc32c = static_cast<std::int32_t>(s.vehicle_crc32c);
  m.rate_hz = s.rate_hz;
  m.filter_order = s.filter_order;
  m.filter_cutoff_hz = s.filter_cutoff_hz;
  m.channels = static_cast<std::int32_t>(s.channel.size());
  for (std::size_t c = 0; c < s.channel.size(); ++c) {
    const NodeSetup::Channel& channel = s.channel[c];
    wire_text::put_text(channel.name, m.channel_name[c]);
    m.role[c] = static_cast<std::int32_t>(channel.role);
    m.mount[c] = channel.mount;
    std::ranges::copy(channel.position_m, m.position_m[c]);
    std::ranges::copy(channel.direction, m.direction[c]);
    m.range_m_s2[c] = channel.range_m_s2;
    m.scale_m_s2_per_count[c] = channel.scale_m_s2_per_count;
    m.offset_counts[c] = channel.offset_counts;
    m.delay_s[c] = channel.delay_s;
  }
  for (std::size_t line = 0; line < s.encoder.size(); ++line) {
    m.wheel[line] = s.encoder[line].wheel;
    m.pulses_per_turn[line] = s.encoder[line].pulses_per_turn;
    m.encoder[line] = s.encoder[line].traits;
    m.datum_rad[line] = s.encoder[line].datum_rad;
    m.datum_sigma_rad[line] = s.encoder[line].datum_sigma_rad;
  }
  return wire_format::encode(m);
}

std::optional<NodeSetup> decode_setup(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::setup_t>(bytes);
  if (!m || !in_bounds(*m)) return std::nullopt;
  NodeSetup s{.node = m->node,
              .name = wire_text::text_until_zero(m->name),
              .vehicle = wire_text::text_until_zero(m->vehicle),
              .vehicle_crc32c = static_cast<std::uint32_t>(m->vehicle_crc32c),
              .rate_hz = m->rate_hz,
              .filter_order = m->filter_order,
              .filter_cutoff_hz = m->filter_cutoff_hz,
              .channel = {},
              .encoder = {}};
  for (std::int32_t c = 0; c < m->channels; ++c) {
    NodeSetup::Channel& channel = s.channel.emplace_back();
    channel.name = wire_text::text_until_zero(m->channel_name[c]);
    channel.role = static_cast<ChannelRole>(m->role[c]);
    channel.mount = m->mount[c];
    std::ranges::copy(m->position_m[c], channel.position_m.begin());
    std::ranges::copy(m->direction[c], channel.direction.begin());
    channel.range_m_s2 = m->range_m_s2[c];
    channel.scale_m_s2_per_count = m->scale_m_s2_per_count[c];
    channel.offset_counts = m->offset_counts[c];
    channel.delay_s = m->delay_s[c];
  }
  for (std::size_t line = 0; line < s.encoder.size(); ++line)
    s.encoder[line] = {m->wheel[line], m->pulses_per_turn[line], m->encoder[line], m->datum_rad[line],
                       m->datum_sigma_rad[line]};
  return s;
}

}  // namespace roadbalance
