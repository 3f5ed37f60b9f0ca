#include "common/bus/verification.hpp"

#include <utility>
#include <wire/verification_t.hpp>

#include "common/bus/wire_format.hpp"
#include "common/bus/wire_text.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {
namespace {

static_assert(sizeof(wire::verification_t::text) == kMostVerificationBytes);

void put(const Eigen::Vector2d& from, double (&to)[2]) {
  to[0] = from.x();
  to[1] = from.y();
}

void put(const Eigen::Matrix2d& from, double (&to)[2][2]) {
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 2; ++column) to[row][column] = from(row, column);
}

Eigen::Vector2d vector(const double (&from)[2]) {
  return {from[0], from[1]};
}

Eigen::Matrix2d matrix(const double (&from)[2][2]) {
  Eigen::Matrix2d to;
  to << from[0][0], from[0][1], from[1][0], from[1][1];
  return to;
}

template <typename Enum>
bool is_enumerator(std::int32_t value, Enum last) {
  return 0 <= value && value <= static_cast<std::int32_t>(last);
}

bool in_bounds(const wire::verification_t& m) {
  return 0 <= m.wheel && m.wheel < kWheels && is_enumerator(m.state, VerificationState::kKnown) &&
         is_enumerator(m.verdict, VerificationVerdict::kMore) &&
         is_enumerator(m.placement, WeightPlacement::kNoEffect);
}

}  // namespace

std::vector<std::uint8_t> encode(const WheelVerification& v) {
  wire::verification_t m{};
  m.wheel = v.wheel;
  m.time_ns = v.time_ns;
  m.state = static_cast<std::int32_t>(v.state);
  m.verdict = static_cast<std::int32_t>(v.verdict);
  m.placement = static_cast<std::int32_t>(v.placement);
  m.fitted_known = v.fitted_known ? 1 : 0;
  put(v.before_g, m.before_g);
  put(v.before_covariance_g2, m.before_covariance_g2);
  put(v.after_g, m.after_g);
  put(v.after_covariance_g2, m.after_covariance_g2);
  put(v.fitted_g, m.fitted_g);
  m.weight_radius_m = v.weight_radius_m;
  m.reduction = v.reduction;
  m.sigma_reduction = v.sigma_reduction;
  wire_text::put_text(v.text, m.text, m.size);
  return wire_format::encode(m);
}

std::optional<WheelVerification> decode_verification(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::verification_t>(bytes);
  if (!m || !in_bounds(*m)) return std::nullopt;
  auto text = wire_text::text_of(m->text, m->size);
  if (!text) return std::nullopt;
  WheelVerification v;
  v.wheel = m->wheel;
  v.time_ns = m->time_ns;
  v.state = static_cast<VerificationState>(m->state);
  v.verdict = static_cast<VerificationVerdict>(m->verdict);
  v.placement = static_cast<WeightPlacement>(m->placement);
  v.fitted_known = m->fitted_known != 0;
  v.before_g = vector(m->before_g);
  v.before_covariance_g2 = matrix(m->before_covariance_g2);
  v.after_g = vector(m->after_g);
  v.after_covariance_g2 = matrix(m->after_covariance_g2);
  v.fitted_g = vector(m->fitted_g);
  v.weight_radius_m = m->weight_radius_m;
  v.reduction = m->reduction;
  v.sigma_reduction = m->sigma_reduction;
  v.text = std::move(*text);
  return v;
}

}  // namespace roadbalance
