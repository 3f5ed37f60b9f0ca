#include "host/analysis/identify/diagnostics.hpp"

#include <algorithm>
#include <cmath>

#include "common/text/format.hpp"
#include "host/analysis/identify/first_order.hpp"

namespace roadbalance {
namespace {

/// Where to drive as long again, so that the speeds separate an unbalance from a force.
std::string separating_speeds(double greatest_m_s) {
  constexpr double kSlowest_km_h = 50.0;  // an unbalance hardly shakes below
  constexpr double kRound_km_h = 5.0;
  const double slow_km_h = kRound_km_h * std::floor(3.6 * kSeparatingShare * greatest_m_s / kRound_km_h);
  if (slow_km_h >= kSlowest_km_h) return format("at %.0f km/h or slower", slow_km_h);
  return format("at %.0f km/h or faster",
                kRound_km_h * std::ceil(3.6 * greatest_m_s / kSeparatingShare / kRound_km_h));
}

/// The two answers of each wheel.
void tell_forces(const std::array<Balance, kWheels>& balance, std::vector<std::string>& sentences) {
  std::string wheels;
  for (const Balance& wheel : balance)
    if (wheel.state == Unknown::kNone && wheel.force_state != ForceState::kNotJudged)
      wheels += format("%s %s %.1f ± %.1f g and %.0f ± %.0f N", wheels.empty() ? "" : ",",
                       kWheelNames[static_cast<std::size_t>(wheel.wheel)], wheel.alone_g, wheel.sigma_alone_g,
                       wheel.force_n, wheel.sigma_force_n);
  if (!wheels.empty())
    sentences.push_back(
        "the grams are the correction, which leaves the least force at the speeds driven; of it, unbalance "
        "alone and tyre's force:" +
        wheels);
}

void remark_on_forces(const std::array<Balance, kWheels>& balance, std::vector<std::string>& sentences) {
  for (const Balance& wheel : balance) {
    if (wheel.state != Unknown::kNone || wheel.force_state != ForceState::kNotSeparable) continue;
    sentences.push_back(
        format("not separable: %.0f–%.0f km/h hardly tell an unbalance from a tyre's force variation, which "
               "does not grow with speed; the ± of both take its usual size for known. Drive once "
               "more as long as this ",
               3.6 * wheel.least_speed_m_s, 3.6 * wheel.greatest_speed_m_s) +
        separating_speeds(wheel.greatest_speed_m_s));
    return;
  }
}

}  // namespace

std::vector<std::string> diagnostics(const std::array<Balance, kWheels>& balance) {
  std::vector<std::string> sentences;
  if (std::ranges::none_of(balance, [](const Balance& b) { return b.state == Unknown::kNone; }))
    return sentences;
  tell_forces(balance, sentences);
  remark_on_forces(balance, sentences);
  sentences.emplace_back(
      "static unbalance only: couple unbalance, which shakes the steering, leaves no trace in vertical "
      "sensors");
  return sentences;
}

}  // namespace roadbalance
