#include "common/bus/compensation.hpp"

#include <wire/compensation_t.hpp>

#include "common/bus/fields.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<Compensation> {
  using Wire = wire::compensation_t;
  static void list(auto& field, auto& c, auto& m) {
    field(c.wheel, m.wheel, below(kWheels));
    field(c.time_ns, m.time_ns);
    field(c.advice, m.advice, up_to(Advice::kLeaveSmall));
    field(c.radii, m.radii);
    field.rows(c.plan.step, m.steps, kMostWeightSteps, [&](auto& step, std::size_t k) {
      field(step.action, m.action[k], up_to(WeightAction::kAdd));
      field(step.weight.mass_g, m.mass_g[k]);
      field(step.weight.angle_rad, m.angle_rad[k]);
      field(step.weight.place.radius_m, m.radius_m[k]);
      field(step.weight.place.kind, m.kind[k], up_to(WeightKind::kAdhesive));
      field(step.weight.place.plane, m.plane[k], up_to(RimPlane::kOuter));
      field.read_only(step.from.mass_g, m.mass_g[k]);
      field(step.from.angle_rad, m.from_angle_rad[k]);
      field(step.from.place.radius_m, m.from_radius_m[k]);
      field.read_only(step.from.place.kind, m.kind[k]);
      field(step.from.place.plane, m.from_plane[k], up_to(RimPlane::kOuter));
    });
    field(c.plan.applied_g_m, m.applied_g_m);
    field(c.verdict.residual_g, m.residual_g);
    field(c.verdict.shop_g, m.shop_g);
    field(c.verdict.permissible_g, m.permissible_g);
    field(c.verdict.permissible_grade_mm_s, m.permissible_grade_mm_s);
    field(c.verdict.grade_mm_s, m.grade_mm_s);
    field(c.verdict.by_rotor, m.by_rotor);
    field(c.verdict.force_left_share, m.force_left_share);
    field(c.wanted_sigma_g, m.wanted_sigma_g);
    field(c.seconds_wanted, m.seconds_wanted);
    field(c.seat_now_m_s2, m.seat_now_m_s2);
    field(c.seat_left_m_s2, m.seat_left_m_s2);
    field.text(c.verdict.incurable, m.incurable, m.size);
  }
};

}  // namespace wire_fields

static_assert(sizeof(wire::compensation_t::action) / sizeof(std::int32_t) == kMostWeightSteps);
static_assert(sizeof(wire::compensation_t::incurable) == kMostReasonBytes);

std::vector<std::uint8_t> encode(const Compensation& message) {
  return wire_fields::encode(message);
}

std::optional<Compensation> decode_compensation(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Compensation>(bytes);
}

}  // namespace roadbalance
