#include "host/analysis/identify/refusal.hpp"

#include <algorithm>
#include <cmath>

#include "common/text/format.hpp"
#include "common/vehicle/sensor_map.hpp"

namespace roadbalance {
namespace {

using Kind = UncertainQuantity::Kind;

constexpr double kGoodFriction_n = 60.0;  ///< of a strut

std::string wheel_name(Eigen::Index wheel) {
  return kWheelNames[static_cast<std::size_t>(wheel)];
}

/// "rear_left damper", "front stabiliser", "roll inertia"
std::string parameter_name(Eigen::Index p) {
  if (p == kBodyMass) return "body's mass";
  if (p == kRollInertia) return "roll inertia";
  if (p == kPitchInertia) return "pitch inertia";
  if (p < kSpring) return wheel_name(p - kWheelMass) + " mass";
  if (p < kDamper) return wheel_name(p - kSpring) + " spring";
  if (p < kStabiliser) return wheel_name(p - kDamper) + " damper";
  if (p < kTyre) return std::string(p == kStabiliser ? "front" : "rear") + " stabiliser";
  if (p < kTyreDamper) return wheel_name(p - kTyre) + " tyre";
  return wheel_name(p - kTyreDamper) + " tyre's damper";
}

const char* parameter_unit(Eigen::Index p) {
  if (p == kRollInertia || p == kPitchInertia) return "kg m²";
  if (p < kSpring) return "kg";
  return (p >= kDamper && p < kStabiliser) || p >= kTyreDamper ? "N s/m" : "N/m";
}

/// "channel 3 (z) of node front"
std::string channel_name(Eigen::Index input, const VehicleConfig& vehicle) {
  const SensorMap::Input at = SensorMap::from(vehicle).input[static_cast<std::size_t>(input)];
  const NodeConfig& node = vehicle.node[static_cast<std::size_t>(at.node)];
  const ChannelConfig& channel = node.channel[static_cast<std::size_t>(at.channel)];
  return "channel " + channel.name + " of node " + node.name;
}

/// What is found, and what vehicle.toml has.
std::string found_sentence(const Deviation& off, const CarPrior& prior, const VehicleConfig& vehicle) {
  const Eigen::Index at = off.quantity.index;
  switch (off.quantity.kind) {
    case Kind::kParameter: {
      const double known = prior.value(at);
      const double sigma = at >= kTyreDamper ? prior.sigma(at) : known * prior.sigma(at);
      return format("%s: the drive says %.4g ± %.2g %s and vehicle.toml %.4g ± %.2g",
                    parameter_name(at).c_str(), off.value, off.sigma, parameter_unit(at), known, sigma);
    }
    case Kind::kGain:
      return format("%s: it seems to read %.1f ± %.1f %% too %s, and vehicle.toml has it good to %.1f %%",
                    channel_name(at, vehicle).c_str(), 100.0 * std::abs(off.value - 1.0), 100.0 * off.sigma,
                    off.value > 1.0 ? "much" : "little", 100.0 * prior.gain_sigma(at));
    case Kind::kFriction:
      return format("%s: its strut seems to have a dry friction of %.0f ± %.0f N", wheel_name(at).c_str(),
                    off.value, off.sigma);
    case Kind::kRebound:
      return format("%s: its damper seems %.0f ± %.0f %% harder in rebound than in the mean",
                    wheel_name(at).c_str(), 100.0 * off.value, 100.0 * off.sigma);
    case Kind::kBracket:
      return format("%s: its bracket seems to resonate at %.0f Hz", channel_name(at, vehicle).c_str(),
                    1.0 / std::sqrt(std::abs(off.value)));
    case Kind::kStruts:
      break;
  }
  return format(
      "the struts: what is not linear in their forces on body and wheels differs by a factor of %.2f ± %.2f",
      off.value, off.sigma);
}

/// What to do about it.
const char* advice(Kind kind) {
  switch (kind) {
    case Kind::kParameter:
      return "either vehicle.toml has not this car's value, or not its sensors' places, directions and "
             "ranges";
    case Kind::kGain:
      return "look at its place, direction and range in vehicle.toml and at its mounting, and calibrate it";
    case Kind::kBracket:
      return "make its mounting stiffer, or put it elsewhere";
    case Kind::kFriction:
    case Kind::kRebound:
      return "look at the strut, and at the places of the sensors above and below it in vehicle.toml";
    case Kind::kStruts:
      break;
  }
  return "look at the struts' mounts, and at the sensors' places in vehicle.toml";
}

const Deviation* farthest(const PosteriorCar& car) {
  const auto found = std::ranges::max_element(
      car.deviations, {}, [](const Deviation& deviation) { return std::abs(deviation.sigmas); });
  return found == car.deviations.end() ? nullptr : &*found;
}

}  // namespace

std::string refusal(const std::optional<PosteriorCar>& car, const CarPrior& prior,
                    const VehicleConfig& vehicle) {
  if (!car)
    return "the drive does not determine the car: drive on a rougher road, where left and right wheels "
           "meet bumps of their own";
  const Deviation* const off = farthest(*car);
  if (!off || std::abs(off->sigmas) < kMostSigmas) return "";
  return found_sentence(*off, prior, vehicle) +
         format(", %.0f times as far apart as that allows: ", std::abs(off->sigmas)) +
         advice(off->quantity.kind) + "; more driving does not mend it";
}

std::string remark_on_scale(const PosteriorCar& car) {
  return format(
      "the scale of grams and N/m rests on the wheels' masses (± %.1f %%) and the sensors' gains (± %.1f %%) "
      "in vehicle.toml: no drive shows an error that all masses, or all gains, share",
      100.0 * car.mass_scale_sigma, 100.0 * car.gain_scale_sigma);
}

std::vector<std::string> remarks_on_deviations(const std::optional<PosteriorCar>& car, const CarPrior& prior,
                                               const VehicleConfig& vehicle) {
  std::vector<std::string> sentences;
  const Deviation* const off = car ? farthest(*car) : nullptr;
  if (!off || std::abs(off->sigmas) >= kMostSigmas) return sentences;
  const bool told = std::abs(off->sigmas) >= kToldSigmas;
  if (told)
    sentences.push_back(found_sentence(*off, prior, vehicle) +
                        "; the estimate goes by what it found: " + advice(off->quantity.kind));
  for (const Deviation& each : car->deviations)
    if (!(told && &each == off) && each.quantity.kind == Kind::kFriction && each.value > kGoodFriction_n &&
        each.value > kToldSigmas * each.sigma)
      sentences.push_back(found_sentence(each, prior, vehicle) +
                          ", more than a good one: a bent or dry strut; the estimate goes by it");
  return sentences;
}

}  // namespace roadbalance
