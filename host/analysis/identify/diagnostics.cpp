#include "host/analysis/identify/diagnostics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/text/format.hpp"
#include "host/analysis/identify/first_order.hpp"

namespace roadbalance {
namespace {

/// A mass that is right seems wrong by so much at the end of one drive in a hundred.  An estimate every
/// second is no drive of its own: watched all through, more drives show it at some time.
constexpr double kSigmas = 2.5;

/// "5 ± 1 % larger"
std::string share(double value, double sigma) {
  return format("%.0f ± %.0f %% %s", 100.0 * std::abs(value), std::max(1.0, 100.0 * sigma),
                value > 0.0 ? "larger" : "smaller");
}

bool stands_out(double value, double sigma) {
  return sigma > 0.0 && std::abs(value) > kSigmas * sigma;
}

void remark_on_masses(const Identification& found, std::vector<std::string>& sentences) {
  if (stands_out(found.mass_share[0], found.sigma_mass_share[0]))
    sentences.push_back("the wheels' equations do not fit the body's: the wheels' masses seem " +
                        share(found.mass_share[0], found.sigma_mass_share[0]) +
                        " than mass_kg says, or the body's mass the other way; grams are in proportion to "
                        "mass_kg, so weigh a wheel with its carrier, and the car with its load");
  for (std::size_t w = 0; w < kWheels; ++w) {
    const double value = found.mass_share[1 + w], sigma = found.sigma_mass_share[1 + w];
    if (found.misfit_chance[1 + w] > kMisfitChance) continue;
    std::string why = "its damper or tyre is far from linear, or the road is of an unusual kind";
    if (stands_out(value, sigma))
      why = "its mass seems " + share(value, sigma) + " than mass_kg says, or " + why;
    sentences.push_back(std::string(kWheelNames[w]) + ": one linear car does not fit what it does (chance " +
                        format("%.1g", found.misfit_chance[1 + w]) + "): " + why +
                        "; its grams may be wrong by more than their ±");
  }
  if (found.misfit_chance[0] < kMisfitChance)
    sentences.push_back(format(
        "heave, roll and pitch do not fit one set of springs and dampers (chance %.1g): the body's "
        "mass and inertias in vehicle.toml are not those of this car and load, or a damper is far from "
        "linear",
        found.misfit_chance[0]));
}

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

std::string misfitting(const Identification& identification) {
  std::string names;
  for (std::size_t w = 0; w < kWheels; ++w)
    if (identification.misfit_chance[1 + w] < kMisfitChance)
      names += (names.empty() ? "" : ", ") + std::string(kWheelNames[w]);
  if (names.empty() && stands_out(identification.mass_share[0], identification.sigma_mass_share[0]))
    names = "all wheels together";
  if (identification.misfit_chance[0] < kMisfitChance)
    names += (names.empty() ? "" : ", ") + std::string("body");
  return names;
}

std::vector<std::string> diagnostics(const Identification& identification,
                                     const std::array<Balance, kWheels>& balance) {
  std::vector<std::string> sentences;
  if (std::ranges::none_of(balance, [](const Balance& b) { return b.state == Unknown::kNone; }))
    return sentences;
  if (identification.state == Unknown::kNone) {
    sentences.emplace_back(
        "the scale of grams and N/m rests on the wheels' masses and the sensors' gains in vehicle.toml: no "
        "drive shows an error that all masses, or all gains, share");
    remark_on_masses(identification, sentences);
  }
  tell_forces(balance, sentences);
  remark_on_forces(balance, sentences);
  sentences.emplace_back(
      "static unbalance only: couple unbalance, which shakes the steering, leaves no trace in vertical "
      "sensors");
  return sentences;
}

}  // namespace roadbalance
