#include "common/bus/results.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <wire/balance_t.hpp>
#include <wire/identification_t.hpp>
#include <wire/level_t.hpp>
#include <wire/spectrum_t.hpp>

#include "common/bus/node_number.hpp"
#include "common/bus/wire_format.hpp"

namespace roadbalance {
namespace {

template <typename Array, typename T>
void put(const Array& from, T* to) {
  std::copy(from.begin(), from.end(), to);
}

template <typename T, typename Array>
void take(const T* from, Array& to) {
  std::copy_n(from, to.size(), to.begin());
}

bool is_state(std::int32_t value) {
  return 0 <= value && value <= static_cast<std::int32_t>(Unknown::kInStep);
}

bool in_bounds(const wire::level_t& m) {
  const auto is_number = [](double value) { return std::isfinite(value); };
  const auto is_size = [](double value) { return std::isfinite(value) && value >= 0.0; };
  const auto is_known_or_not = [](double value) { return !std::isinf(value); };
  return is_node(m.node) && is_size(m.seconds) && std::ranges::all_of(m.mean, is_number) &&
         std::ranges::all_of(m.rms, is_size) && std::ranges::all_of(m.peak, is_size) &&
         is_known_or_not(m.speed_m_s) && std::ranges::all_of(m.rotation_hz, is_known_or_not);
}

}  // namespace

std::vector<std::uint8_t> encode(const Level& l) {
  wire::level_t m{};
  m.node = l.node;
  m.time_ns = l.time_ns;
  m.seconds = l.seconds;
  put(l.mean, m.mean);
  put(l.rms, m.rms);
  put(l.peak, m.peak);
  m.overload = static_cast<std::int32_t>(l.overload);
  m.dead = static_cast<std::int32_t>(l.dead);
  m.speed_m_s = l.speed_m_s;
  put(l.rotation_hz, m.rotation_hz);
  m.skipped = l.skipped;
  return wire_format::encode(m);
}

std::optional<Level> decode_level(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::level_t>(bytes);
  if (!m || !in_bounds(*m)) return std::nullopt;
  Level l;
  l.node = m->node;
  l.time_ns = m->time_ns;
  l.seconds = m->seconds;
  take(m->mean, l.mean);
  take(m->rms, l.rms);
  take(m->peak, l.peak);
  l.overload = static_cast<std::uint32_t>(m->overload);
  l.dead = static_cast<std::uint32_t>(m->dead);
  l.speed_m_s = m->speed_m_s;
  take(m->rotation_hz, l.rotation_hz);
  l.skipped = m->skipped;
  return l;
}

std::vector<std::uint8_t> encode(const SpectrumPart& s) {
  assert(s.density.size() <= kSpectrumBinsPerPart);
  wire::spectrum_t m{};
  m.viewer = s.viewer;
  m.node = s.node;
  m.channel = s.channel;
  m.state = static_cast<std::int32_t>(s.state);
  m.time_ns = s.time_ns;
  m.part = s.part;
  m.parts = s.parts;
  m.bins = static_cast<std::int32_t>(s.density.size());
  m.first_hz = s.first_hz;
  m.step_hz = s.step_hz;
  m.enbw_hz = s.enbw_hz;
  m.averages = s.averages;
  m.held = s.held ? 1 : 0;
  put(s.density, m.density);
  return wire_format::encode(m);
}

std::optional<SpectrumPart> decode_spectrum(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::spectrum_t>(bytes);
  if (!m || !is_node(m->node) || m->channel < 0 || m->channel >= kChannels || m->parts < 1 || m->part < 0 ||
      m->part >= m->parts || m->bins < 0 || m->bins > kSpectrumBinsPerPart || m->held < 0 || m->held > 1 ||
      m->state < 0 || m->state > static_cast<std::int32_t>(TransferState::kTooMuch) ||
      (m->state != 0 && m->bins > 0))
    return std::nullopt;
  SpectrumPart s;
  s.viewer = m->viewer;
  s.node = m->node;
  s.channel = m->channel;
  s.state = static_cast<TransferState>(m->state);
  s.time_ns = m->time_ns;
  s.part = m->part;
  s.parts = m->parts;
  s.first_hz = m->first_hz;
  s.step_hz = m->step_hz;
  s.enbw_hz = m->enbw_hz;
  s.averages = m->averages;
  s.held = m->held == 1;
  s.density.assign(m->density, m->density + m->bins);
  return s;
}

std::vector<std::uint8_t> encode(const Identification& i) {
  assert(i.speed_class.size() <= kMaxSpeedClasses);
  wire::identification_t m{};
  m.time_ns = i.time_ns;
  m.seconds_used = i.seconds_used;
  m.sections = i.sections;
  m.state = static_cast<std::int32_t>(i.state);
  m.seconds_needed = i.seconds_needed;
  m.least_speed_m_s = i.least_speed_m_s;
  put(i.spring_n_m, m.spring_n_m);
  put(i.sigma_spring_n_m, m.sigma_spring_n_m);
  put(i.damper_n_s_m, m.damper_n_s_m);
  put(i.sigma_damper_n_s_m, m.sigma_damper_n_s_m);
  put(i.stabiliser_n_m, m.stabiliser_n_m);
  put(i.sigma_stabiliser_n_m, m.sigma_stabiliser_n_m);
  put(i.tyre_n_m, m.tyre_n_m);
  put(i.sigma_tyre_n_m, m.sigma_tyre_n_m);
  m.condition = i.condition;
  put(i.mass_share, m.mass_share);
  put(i.sigma_mass_share, m.sigma_mass_share);
  put(i.misfit, m.misfit);
  put(i.misfit_chance, m.misfit_chance);
  m.speed_classes = static_cast<std::int32_t>(i.speed_class.size());
  for (std::size_t k = 0; k < i.speed_class.size(); ++k) {
    m.speed_m_s[k] = i.speed_class[k].speed_m_s;
    m.speed_seconds[k] = i.speed_class[k].seconds;
  }
  return wire_format::encode(m);
}

std::optional<Identification> decode_identification(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::identification_t>(bytes);
  if (!m || !is_state(m->state) || m->speed_classes < 0 || m->speed_classes > kMaxSpeedClasses)
    return std::nullopt;
  Identification i;
  i.time_ns = m->time_ns;
  i.seconds_used = m->seconds_used;
  i.sections = m->sections;
  i.state = static_cast<Unknown>(m->state);
  i.seconds_needed = m->seconds_needed;
  i.least_speed_m_s = m->least_speed_m_s;
  take(m->spring_n_m, i.spring_n_m);
  take(m->sigma_spring_n_m, i.sigma_spring_n_m);
  take(m->damper_n_s_m, i.damper_n_s_m);
  take(m->sigma_damper_n_s_m, i.sigma_damper_n_s_m);
  take(m->stabiliser_n_m, i.stabiliser_n_m);
  take(m->sigma_stabiliser_n_m, i.sigma_stabiliser_n_m);
  take(m->tyre_n_m, i.tyre_n_m);
  take(m->sigma_tyre_n_m, i.sigma_tyre_n_m);
  i.condition = m->condition;
  take(m->mass_share, i.mass_share);
  take(m->sigma_mass_share, i.sigma_mass_share);
  take(m->misfit, i.misfit);
  take(m->misfit_chance, i.misfit_chance);
  for (std::int32_t k = 0; k < m->speed_classes; ++k)
    i.speed_class.push_back({.speed_m_s = m->speed_m_s[k], .seconds = m->speed_seconds[k]});
  return i;
}

std::vector<std::uint8_t> encode(const Balance& b) {
  wire::balance_t m{};
  m.wheel = b.wheel;
  m.time_ns = b.time_ns;
  m.state = static_cast<std::int32_t>(b.state);
  m.unbalance_g = b.unbalance_g;
  m.angle_rad = b.angle_rad;
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 2; ++column) m.covariance_g2[row][column] = b.covariance_g2(row, column);
  m.sigma_g = b.sigma_g;
  m.sigma_rad = b.sigma_rad;
  m.weight_radius_m = b.weight_radius_m;
  m.weight_angle_rad = b.weight_angle_rad;
  m.seconds_used = b.seconds_used;
  m.sigma_drive_g = b.sigma_drive_g;
  m.phase_drift_rad = b.phase_drift_rad;
  m.least_speed_m_s = b.least_speed_m_s;
  m.greatest_speed_m_s = b.greatest_speed_m_s;
  m.force_state = static_cast<std::int32_t>(b.force_state);
  m.force_n = b.force_n;
  m.force_angle_rad = b.force_angle_rad;
  m.sigma_force_n = b.sigma_force_n;
  m.alone_g = b.alone_g;
  m.alone_angle_rad = b.alone_angle_rad;
  m.sigma_alone_g = b.sigma_alone_g;
  return wire_format::encode(m);
}

std::optional<Balance> decode_balance(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::balance_t>(bytes);
  if (!m || !is_state(m->state) || m->wheel < 0 || m->wheel >= kWheels || m->force_state < 0 ||
      m->force_state > static_cast<std::int32_t>(ForceState::kNotSeparable))
    return std::nullopt;
  Balance b;
  b.wheel = m->wheel;
  b.time_ns = m->time_ns;
  b.state = static_cast<Unknown>(m->state);
  b.unbalance_g = m->unbalance_g;
  b.angle_rad = m->angle_rad;
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 2; ++column) b.covariance_g2(row, column) = m->covariance_g2[row][column];
  b.sigma_g = m->sigma_g;
  b.sigma_rad = m->sigma_rad;
  b.weight_radius_m = m->weight_radius_m;
  b.weight_angle_rad = m->weight_angle_rad;
  b.seconds_used = m->seconds_used;
  b.sigma_drive_g = m->sigma_drive_g;
  b.phase_drift_rad = m->phase_drift_rad;
  b.least_speed_m_s = m->least_speed_m_s;
  b.greatest_speed_m_s = m->greatest_speed_m_s;
  b.force_state = static_cast<ForceState>(m->force_state);
  b.force_n = m->force_n;
  b.force_angle_rad = m->force_angle_rad;
  b.sigma_force_n = m->sigma_force_n;
  b.alone_g = m->alone_g;
  b.alone_angle_rad = m->alone_angle_rad;
  b.sigma_alone_g = m->sigma_alone_g;
  return b;
}

}  // namespace roadbalance
