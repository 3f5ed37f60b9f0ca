#include "common/bus/weight_check.hpp"

#include <wire/verification_t.hpp>

#include "common/bus/fields.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<WeightCheck> {
  using Wire = wire::verification_t;
  static void list(auto& field, auto& v, auto& m) {
    field(v.wheel, m.wheel, below(kWheels));
    field(v.time_ns, m.time_ns);
    field(v.state, m.state, up_to(WeightCheckState::kKnown));
    field(v.verdict, m.verdict, up_to(WeightCheckVerdict::kMore));
    field(v.placement, m.placement, up_to(WeightPlacement::kNoEffect));
    field(v.fitted_known, m.fitted_known);
    field(v.before_g, m.before_g);
    field(v.before_covariance_g2, m.before_covariance_g2);
    field(v.after_g, m.after_g);
    field(v.after_covariance_g2, m.after_covariance_g2);
    field(v.fitted_g, m.fitted_g);
    field(v.weight_radius_m, m.weight_radius_m);
    field(v.reduction, m.reduction);
    field(v.sigma_reduction, m.sigma_reduction);
    field.text(v.text, m.text, m.size);
  }
};

}  // namespace wire_fields

static_assert(sizeof(wire::verification_t::text) == kMostWeightCheckBytes);

std::vector<std::uint8_t> encode(const WeightCheck& check) {
  return wire_fields::encode(check);
}

std::optional<WeightCheck> decode_weight_check(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<WeightCheck>(bytes);
}

}  // namespace roadbalance
