#include "common/bus/compensation.hpp"

#include <algorithm>
#include <cassert>
#include <utility>
#include <wire/compensation_t.hpp>

#include "common/bus/wire_format.hpp"
#include "common/bus/wire_text.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {
namespace {

static_assert(sizeof(wire::compensation_t::action) / sizeof(std::int32_t) == kMostWeightSteps);
static_assert(sizeof(wire::compensation_t::incurable) == kMostReasonBytes);

/// The first so many are of an enumeration that ends with `last`.
template <typename Enumeration>
bool all_up_to(const std::int32_t* values, std::int32_t count, Enumeration last) {
  return std::all_of(values, values + count, [last](std::int32_t value) {
    return 0 <= value && value <= static_cast<std::int32_t>(last);
  });
}

bool in_bounds(const wire::compensation_t& m) {
  return 0 <= m.steps && m.steps <= static_cast<std::int32_t>(kMostWeightSteps) && 0 <= m.wheel &&
         m.wheel < kWheels && 0 <= m.advice && m.advice <= static_cast<std::int32_t>(Advice::kLeaveSmall) &&
         all_up_to(m.action, m.steps, WeightAction::kAdd) &&
         all_up_to(m.kind, m.steps, WeightKind::kAdhesive) && all_up_to(m.plane, m.steps, RimPlane::kOuter) &&
         all_up_to(m.from_plane, m.steps, RimPlane::kOuter);
}

}  // namespace

std::vector<std::uint8_t> encode(const Compensation& c) {
  assert(c.plan.step.size() <= kMostWeightSteps);
  wire::compensation_t m{};
  m.wheel = c.wheel;
  m.time_ns = c.time_ns;
  m.advice = static_cast<std::int32_t>(c.advice);
  m.radii = c.radii;
  m.steps = static_cast<std::int32_t>(c.plan.step.size());
  for (std::size_t k = 0; k < c.plan.step.size(); ++k) {
    const WeightStep& step = c.plan.step[k];
    m.action[k] = static_cast<std::int32_t>(step.action);
    m.mass_g[k] = step.weight.mass_g;
    m.angle_rad[k] = step.weight.angle_rad;
    m.radius_m[k] = step.weight.place.radius_m;
    m.from_angle_rad[k] = step.from.angle_rad;
    m.from_radius_m[k] = step.from.place.radius_m;
    m.kind[k] = static_cast<std::int32_t>(step.weight.place.kind);
    m.plane[k] = static_cast<std::int32_t>(step.weight.place.plane);
    m.from_plane[k] = static_cast<std::int32_t>(step.from.place.plane);
  }
  m.applied_g_m[0] = c.plan.applied_g_m.real();
  m.applied_g_m[1] = c.plan.applied_g_m.imag();
  m.residual_g = c.verdict.residual_g;
  m.shop_g = c.verdict.shop_g;
  m.permissible_g = c.verdict.permissible_g;
  m.permissible_grade_mm_s = c.verdict.permissible_grade_mm_s;
  m.grade_mm_s = c.verdict.grade_mm_s;
  m.by_rotor = c.verdict.by_rotor ? 1 : 0;
  m.force_left_share = c.verdict.force_left_share;
  m.wanted_sigma_g = c.wanted_sigma_g;
  m.seconds_wanted = c.seconds_wanted;
  m.seat_now_m_s2 = c.seat_now_m_s2;
  m.seat_left_m_s2 = c.seat_left_m_s2;
  wire_text::put_text(c.verdict.incurable, m.incurable, m.size);
  return wire_format::encode(m);
}

std::optional<Compensation> decode_compensation(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::compensation_t>(bytes);
  if (!m || !in_bounds(*m)) return std::nullopt;
  auto incurable = wire_text::text_of(m->incurable, m->size);
  if (!incurable) return std::nullopt;
  Compensation c;
  c.wheel = m->wheel;
  c.time_ns = m->time_ns;
  c.advice = static_cast<Advice>(m->advice);
  c.radii = m->radii;
  for (std::int32_t k = 0; k < m->steps; ++k) {
    const auto kind = static_cast<WeightKind>(m->kind[k]);
    const WeightPlace place{m->radius_m[k], kind, static_cast<RimPlane>(m->plane[k])};
    const WeightPlace from{m->from_radius_m[k], kind, static_cast<RimPlane>(m->from_plane[k])};
    c.plan.step.push_back({static_cast<WeightAction>(m->action[k]),
                           {m->mass_g[k], m->angle_rad[k], place},
                           {m->mass_g[k], m->from_angle_rad[k], from}});
  }
  c.plan.applied_g_m = {m->applied_g_m[0], m->applied_g_m[1]};
  c.verdict = {.residual_g = m->residual_g,
               .shop_g = m->shop_g,
               .permissible_g = m->permissible_g,
               .permissible_grade_mm_s = m->permissible_grade_mm_s,
               .grade_mm_s = m->grade_mm_s,
               .by_rotor = m->by_rotor != 0,
               .force_left_share = m->force_left_share,
               .incurable = std::move(*incurable)};
  c.wanted_sigma_g = m->wanted_sigma_g;
  c.seconds_wanted = m->seconds_wanted;
  c.seat_now_m_s2 = m->seat_now_m_s2;
  c.seat_left_m_s2 = m->seat_left_m_s2;
  return c;
}

}  // namespace roadbalance
