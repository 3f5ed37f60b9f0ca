#include <cstdio>
#include <numbers>

#include "common/config/section.hpp"
#include "host/analyser/identify_record.hpp"
#include "host/analyser/recorded_vehicle.hpp"
#include "host/calibration/trial_weight.hpp"
#include "tools/rb/datum.hpp"
#include "tools/rb/defects.hpp"
#include "tools/rb/readout.hpp"
#include "tools/rb/wheel_angle.hpp"

namespace roadbalance {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

struct Drive {
  FoundUnbalance found;
  double weight_radius_m;
};

/// Nothing, and said, if the drive did not tell the wheel's unbalance.
std::optional<Drive> unbalance_in(const std::string& folder, const std::string& wheel_name) {
  const auto vehicle = recorded_vehicle(folder);
  const RecordedEstimate found = identify_record(folder);  // refuses what has no vehicle
  warn_of_defects("datum", folder, found.defects);
  const WheelConfig& wheel = wheel_with_mark(*vehicle, wheel_name);
  const Balance& balance = found.estimate.balance[static_cast<std::size_t>(vehicle->place_of(wheel))];
  if (balance.state != Unknown::kNone) {
    std::fprintf(stderr, "rb datum: %s: the unbalance of %s is not known: %s%s%s\n", folder.c_str(),
                 wheel_name.c_str(), reason(balance.state).c_str(), found.obstacle.empty() ? "" : "; ",
                 found.obstacle.c_str());
    return std::nullopt;
  }
  return Drive{FoundUnbalance::from(balance, wheel.encoder), wheel.weight_radius_m};
}

TrialWeight weight_of(const DatumOptions& options, double weight_radius_m) {
  const auto angle_rad = parse_wheel_angle(options.at, options.wheel.ends_with("_left"));
  if (!angle_rad)
    throw ConfigError("--at " + options.at +
                      ": is no place on a wheel; allowed: degrees from the reference point in the direction "
                      "of rotation (90), or the clock with the reference point at 12 (9:00)");
  return {options.grams * options.radius_m.value_or(weight_radius_m) / weight_radius_m, *angle_rad,
          options.at_sigma_deg / kDegrees};
}

}  // namespace

std::optional<FoundDatum> datum_by_weight(const DatumOptions& options) {
  const auto before = unbalance_in(options.before, options.wheel);
  const auto after = before ? unbalance_in(options.after, options.wheel) : std::nullopt;
  if (!after) return std::nullopt;
  if (before->weight_radius_m != after->weight_radius_m)
    throw ConfigError("weight_radius_m of " + options.wheel + " differs between the two recordings");
  const TrialWeight weight = weight_of(options, before->weight_radius_m);
  const auto datum = datum_by_trial_weight(before->found, after->found, weight);
  if (!datum) {
    std::fprintf(stderr,
                 "rb datum: the two drives do not tell the weight: take a heavier one, or drive longer\n");
    return std::nullopt;
  }
  if (!datum->mass_agrees(weight)) {
    std::fprintf(stderr,
                 "rb datum: the drives find %.1f +- %.1f g of change where %.1f g were clipped on: the scale "
                 "is wrong, and with it the angle. Check the wheel's mass_kg, the weight's radius and that "
                 "nothing else was changed; nothing is set\n",
                 datum->change_g, datum->change_sigma_g, weight.mass_g);
    return std::nullopt;
  }
  char sentence[160];
  std::snprintf(sentence, sizeof sentence, "from a trial weight of %.1f g, found as %.1f +- %.1f g",
                weight.mass_g, datum->change_g, datum->change_sigma_g);
  return FoundDatum{datum->datum_rad,
                    datum->sigma_rad,
                    {{"method", "trial_weight"},
                     {"weight_g", weight.mass_g},
                     {"change_g", datum->change_g},
                     {"change_sigma_g", datum->change_sigma_g}},
                    sentence};
}

}  // namespace roadbalance
