#include "common/bus/results.hpp"

#include <wire/balance_t.hpp>
#include <wire/identification_t.hpp>
#include <wire/level_t.hpp>
#include <wire/spectrum_t.hpp>

#include "common/bus/fields.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<Level> {
  using Wire = wire::level_t;
  static void list(auto& field, auto& l, auto& m) {
    field(l.node, m.node, is_node);
    field(l.time_ns, m.time_ns);
    field(l.seconds, m.seconds, is_size);
    field(l.mean, m.mean, is_finite);
    field(l.rms, m.rms, is_size);
    field(l.peak, m.peak, is_size);
    field(l.overload, m.overload);
    field(l.dead, m.dead);
    field(l.clipped, m.clipped);
    field(l.speed_m_s, m.speed_m_s, is_not_infinite);
    field(l.rotation_hz, m.rotation_hz, is_not_infinite);
    field(l.skipped, m.skipped);
  }
};

template <>
struct Fields<SpectrumPart> {
  using Wire = wire::spectrum_t;
  static void list(auto& field, auto& s, auto& m) {
    field(s.viewer, m.viewer);
    field(s.node, m.node, is_node);
    field(s.channel, m.channel, below(kChannels));
    field(s.state, m.state, up_to(SpectralState::kTooMuch));
    field(s.time_ns, m.time_ns);
    field(s.parts, m.parts, at_least(1));
    field(s.part, m.part, below(m.parts));
    field(s.first_hz, m.first_hz);
    field(s.step_hz, m.step_hz);
    field(s.enbw_hz, m.enbw_hz);
    field(s.averages, m.averages);
    field(s.held, m.held, up_to(1));
    field.values(s.density, m.bins, m.density);
    field.require(m.state == 0 || m.bins == 0);
  }
};

template <>
struct Fields<Identification> {
  using Wire = wire::identification_t;
  static void list(auto& field, auto& i, auto& m) {
    field(i.time_ns, m.time_ns);
    field(i.seconds_used, m.seconds_used);
    field(i.sections, m.sections);
    field(i.state, m.state, up_to(Unknown::kInStep));
    field(i.seconds_needed, m.seconds_needed);
    field(i.least_speed_m_s, m.least_speed_m_s);
    field(i.spring_n_m, m.spring_n_m);
    field(i.sigma_spring_n_m, m.sigma_spring_n_m);
    field(i.damper_n_s_m, m.damper_n_s_m);
    field(i.sigma_damper_n_s_m, m.sigma_damper_n_s_m);
    field(i.stabiliser_n_m, m.stabiliser_n_m);
    field(i.sigma_stabiliser_n_m, m.sigma_stabiliser_n_m);
    field(i.tyre_n_m, m.tyre_n_m);
    field(i.sigma_tyre_n_m, m.sigma_tyre_n_m);
    field.rows(i.speed_class, m.speed_classes, kMaxSpeedClasses, [&](auto& speed_class, std::size_t k) {
      field(speed_class.speed_m_s, m.speed_m_s[k]);
      field(speed_class.seconds, m.speed_seconds[k]);
    });
  }
};

template <>
struct Fields<Balance> {
  using Wire = wire::balance_t;
  static void list(auto& field, auto& b, auto& m) {
    field(b.wheel, m.wheel, below(kWheels));
    field(b.time_ns, m.time_ns);
    field(b.state, m.state, up_to(Unknown::kInStep));
    field(b.unbalance_g, m.unbalance_g);
    field(b.angle_rad, m.angle_rad);
    field(b.covariance_g2, m.covariance_g2);
    field(b.sigma_g, m.sigma_g);
    field(b.sigma_rad, m.sigma_rad);
    field(b.weight_radius_m, m.weight_radius_m);
    field(b.weight_angle_rad, m.weight_angle_rad);
    field(b.seconds_used, m.seconds_used);
    field(b.sigma_drive_g, m.sigma_drive_g);
    field(b.phase_drift_rad, m.phase_drift_rad);
    field(b.least_speed_m_s, m.least_speed_m_s);
    field(b.greatest_speed_m_s, m.greatest_speed_m_s);
    field(b.force_state, m.force_state, up_to(ForceState::kNotSeparable));
    field(b.force_n, m.force_n);
    field(b.force_angle_rad, m.force_angle_rad);
    field(b.sigma_force_n, m.sigma_force_n);
    field(b.alone_g, m.alone_g);
    field(b.alone_angle_rad, m.alone_angle_rad);
    field(b.sigma_alone_g, m.sigma_alone_g);
  }
};

}  // namespace wire_fields

static_assert(sizeof(wire::spectrum_t::density) / sizeof(float) == kSpectrumBinsPerPart);
static_assert(sizeof(wire::identification_t::speed_m_s) / sizeof(double) == kMaxSpeedClasses);

std::vector<std::uint8_t> encode(const Level& message) {
  return wire_fields::encode(message);
}
std::vector<std::uint8_t> encode(const SpectrumPart& message) {
  return wire_fields::encode(message);
}
std::vector<std::uint8_t> encode(const Identification& message) {
  return wire_fields::encode(message);
}
std::vector<std::uint8_t> encode(const Balance& message) {
  return wire_fields::encode(message);
}

std::optional<Level> decode_level(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Level>(bytes);
}
std::optional<SpectrumPart> decode_spectrum(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<SpectrumPart>(bytes);
}
std::optional<Identification> decode_identification(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Identification>(bytes);
}
std::optional<Balance> decode_balance(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Balance>(bytes);
}

}  // namespace roadbalance
