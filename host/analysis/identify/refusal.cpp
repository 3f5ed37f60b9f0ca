#include "host/analysis/identify/refusal.hpp"

#include <cstdio>

namespace roadbalance {
namespace {

constexpr double kPlausible = 2.0;  ///< factor between an estimate and vehicle.toml

/// "rear_left damper", "front stabiliser"
std::string name_of(int place) {
  const auto wheel = [&](int first) {
    return std::string(kWheelNames[static_cast<std::size_t>(place - first)]);
  };
  if (place < kEstimatedDamper) return wheel(kEstimatedSpring) + " spring";
  if (place < kEstimatedStabiliser) return wheel(kEstimatedDamper) + " damper";
  if (place < kEstimatedTyre)
    return std::string(place == kEstimatedStabiliser ? "front" : "rear") + " stabiliser";
  return wheel(kEstimatedTyre) + " tyre";
}

std::string implausible_sentence(int place, double found, double priors) {
  char text[400];
  const bool damper = place >= kEstimatedDamper && place < kEstimatedStabiliser;
  std::snprintf(
      text, sizeof text,
      "%s: the drive says %.0f %s and vehicle.toml %.0f, more than a factor of %.0f apart: either "
      "vehicle.toml has not this car's value, or not its sensors' places, directions and ranges, or "
      "%s; if none of it, drive on",
      name_of(place).c_str(), found, damper ? "N s/m" : "N/m", priors, kPlausible,
      damper ? "the damper is worn or far from linear" : "a part is broken");
  return text;
}

std::string weak_sentence(const SuspensionConditioning& found) {
  char text[400];
  std::snprintf(text, sizeof text,
                "the drive does not tell springs, dampers and stabilisers apart, the %s least: their "
                "equations are %.1f "
                "times as far from leaving one free as they are from being met, %.0f times are needed "
                "(condition number "
                "%.0f): drive on, on a rougher road, where left and right wheels meet bumps of their own",
                name_of(found.weakest).c_str(), found.margin, kLeastMargin, found.condition);
  return text;
}

}  // namespace

std::optional<int> implausible(const UnknownVector& x, const Priors& priors) {
  for (int p = 0; p < kEstimatedUnbalance; ++p) {
    const double ratio = x(p) / priors.value(kSpring + p);
    const bool stabiliser = p >= kEstimatedStabiliser && p < kEstimatedTyre;
    if (!stabiliser && !(ratio > 1.0 / kPlausible && ratio < kPlausible)) return p;
  }
  return std::nullopt;
}

std::string refusal(const std::optional<UnknownVector>& x,
                    const std::optional<EstimateCovariance>& covariance, const Priors& priors) {
  if (!x) return "the drive leaves some spring, damper or stabiliser unmoved: drive on a rougher road";
  // Scatter of equations that determine nothing is no covariance: this comes first.
  if (covariance && !(covariance->suspension.margin >= kLeastMargin))
    return weak_sentence(covariance->suspension);
  if (const auto place = implausible(*x, priors))
    return implausible_sentence(*place, (*x)(*place), priors.value(kSpring + *place));
  if (!covariance)
    return "without some tenth of it the drive tells nothing, so how sure it is cannot be told: drive on";
  return "";
}

}  // namespace roadbalance
