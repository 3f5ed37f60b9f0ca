#include "common/bus/setup.hpp"

#include <algorithm>
#include <string_view>
#include <wire/setup_t.hpp>

#include "common/bus/fields.hpp"
#include "common/types/text_crc.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<NodeSetup> {
  using Wire = wire::setup_t;
  static void list(auto& field, auto& s, auto& m) {
    constexpr auto kWheelOrNone = within(-1, kWheels - 1);
    field(s.node, m.node, is_node);
    field.text(s.name, m.name);
    field.text(s.vehicle, m.vehicle);
    field(s.vehicle_crc32c, m.vehicle_crc32c);
    field(s.rate_hz, m.rate_hz);
    field(s.filter_order, m.filter_order);
    field(s.filter_cutoff_hz, m.filter_cutoff_hz);
    field.rows(s.channel, m.channels, kAccelerations, [&](auto& channel, std::size_t k) {
      field.text(channel.name, m.channel_name[k]);
      field(channel.role, m.role[k], up_to(ChannelRole::kUnused));
      field(channel.mount, m.mount[k], kWheelOrNone);
      field(channel.position_m, m.position_m[k]);
      field(channel.direction, m.direction[k]);
      field(channel.range_m_s2, m.range_m_s2[k]);
      field(channel.scale_m_s2_per_count, m.scale_m_s2_per_count[k]);
      field(channel.offset_counts, m.offset_counts[k]);
      field(channel.delay_s, m.delay_s[k]);
    });
    for (std::size_t line = 0; line < kEncoderLines; ++line) {
      auto& encoder = s.encoder[line];
      field(encoder.wheel, m.wheel[line], kWheelOrNone);
      field(encoder.pulses_per_turn, m.pulses_per_turn[line]);
      field(encoder.traits, m.encoder[line]);
      field(encoder.datum_rad, m.datum_rad[line]);
      field(encoder.datum_sigma_rad, m.datum_sigma_rad[line]);
    }
  }
};

}  // namespace wire_fields

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

std::vector<std::uint8_t> encode(const NodeSetup& setup) {
  return wire_fields::encode(setup);
}

std::optional<NodeSetup> decode_setup(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<NodeSetup>(bytes);
}

}  // namespace roadbalance
