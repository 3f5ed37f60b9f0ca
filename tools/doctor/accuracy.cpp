#include "tools/doctor/accuracy.hpp"

#include <algorithm>

#include "common/config/section.hpp"
#include "common/vehicle/linear_model.hpp"
#include "common/vehicle/sensor_map.hpp"
#include "host/analysis/identify/missing_angle.hpp"

namespace roadbalance {
namespace {

void append(std::string& list, const std::string& name) {
  list += (list.empty() ? "" : ", ") + name;
}

/// Names of the wheels of which that is true.
template <typename IsIt>
std::string wheels_that(const VehicleConfig& vehicle, IsIt is_it) {
  std::string names;
  for (const WheelConfig& wheel : vehicle.wheel)
    if (is_it(wheel)) append(names, wheel.name);
  return names;
}

void add_sensors(const VehicleConfig& vehicle, std::vector<Finding>& findings) {
  constexpr const char* kRemedy =
      "[[node.channel]] with direction = [0, 0, 1] and mount = \"WHEEL\", or \"body\" at three places of it";
  try {
    SensorMap::from(vehicle);
  } catch (const ConfigError& error) {
    try {
      SensorMap::of_body(vehicle);
      findings.push_back({"sensors", Finding::kNote,
                          std::string(error.what()) +
                              ": unbalances come from the body alone, with springs, dampers and tyres as the "
                              "file has them.",
                          kRemedy});
    } catch (const ConfigError& of_body) {
      findings.push_back(
          {"sensors", Finding::kIll, std::string(of_body.what()) + ": nothing can be identified.", kRemedy});
    }
  }
}

void add_angles(const VehicleConfig& vehicle, const std::string& file, std::vector<Finding>& findings) {
  std::string why = why_no_angle(vehicle);
  const std::string without = wheels_that(vehicle, [&](const WheelConfig& wheel) {
    return wheel.node.empty() && why.find(wheel.name) == std::string::npos;
  });
  if (why.empty() && !without.empty())
    why = without + ": no node reads an encoder there, so there is no angle";
  if (!why.empty())
    findings.push_back({"angle", Finding::kNote, why + ".",
                        "zero_mark = true  # below [wheel.encoder], and the mark wired to its node"});
  const auto is_unsure = [](const WheelConfig& wheel) {
    return !wheel.node.empty() && wheel.encoder.zero_mark && wheel.encoder.datum_sigma_rad == 0.0;
  };
  const auto remedy = [&](const std::string& names) {
    return "rb datum --vehicle " + file + " --wheel " + names.substr(0, names.find(',')) +
           (names.find(',') == std::string::npos ? "" : "  # and with each other of them");
  };
  const std::string unknown = wheels_that(
      vehicle, [&](const WheelConfig& wheel) { return is_unsure(wheel) && wheel.encoder.datum_rad == 0.0; });
  if (!unknown.empty())
    findings.push_back({"datum", Finding::kNote,
                        unknown +
                            ": nobody has found where the zero mark fires (datum_deg): weights would go "
                            "by the mark, not by the valve.",
                        remedy(unknown)});
  const std::string unsure = wheels_that(
      vehicle, [&](const WheelConfig& wheel) { return is_unsure(wheel) && wheel.encoder.datum_rad != 0.0; });
  if (!unsure.empty())
    findings.push_back({"datum", Finding::kNote,
                        unsure + ": how well datum_deg is known is not said (datum_sigma_deg): the ± of "
                                 "angles leave it out.",
                        remedy(unsure)});
}

/// Keys of values that the file declares exact.
std::string exact(const VehicleConfig& vehicle) {
  std::string keys;
  const auto add = [&](double sigma, const std::string& key) {
    if (sigma == 0.0) append(keys, key);
  };
  add(vehicle.model.body_mass_sigma_kg, "body_mass_sigma_kg");
  add(vehicle.model.roll_inertia_sigma_kg_m2, "roll_inertia_sigma_kg_m2");
  add(vehicle.model.pitch_inertia_sigma_kg_m2, "pitch_inertia_sigma_kg_m2");
  const auto& axles = vehicle.model.axle;
  add(std::ranges::min(axles, {}, &AxleConfig::tyre_damper_sigma_n_s_m).tyre_damper_sigma_n_s_m,
      "tyre_damper_sigma_n_s_m");
  add(std::ranges::min(vehicle.wheel, {}, &WheelConfig::mass_sigma_kg).mass_sigma_kg, "mass_sigma_kg");
  double gain = 1.0;
  for (const NodeConfig& node : vehicle.node)
    for (const ChannelConfig& channel : node.channel)
      if (channel.role == ChannelRole::kAcceleration) gain = std::min(gain, channel.gain_sigma);
  add(gain, "gain_sigma");
  return keys;
}

}  // namespace

std::vector<Finding> accuracy_findings(const VehicleConfig& vehicle, const std::string& file) {
  std::vector<Finding> findings;
  if (!vehicle.model.description.empty()) return findings;
  add_sensors(vehicle, findings);
  add_angles(vehicle, file, findings);
  if (const std::string keys = exact(vehicle); !keys.empty())
    findings.push_back({"sigma", Finding::kNote,
                        "Said to be known exactly (0), as of the simulated car: " + keys +
                            "; the ± of grams leave out what is not.",
                        "sed -i '/sigma[a-z0-9_]* *= *0*\\.\\?0* *\\(#.*\\)\\?$/d' " + file +
                            "  # what is left out has its usual ±"});
  const std::string untold = wheels_that(vehicle, [](const WheelConfig& wheel) {
    return wheel.stock.place.size() == 1 && wheel.stock.place[0].kind == WeightKind::kNotGiven;
  });
  if (!untold.empty())
    findings.push_back({"places", Finding::kNote,
                        untold + ": nobody said where weights go; grams are for weight_radius_m, and do less "
                                 "on a smaller radius.",
                        "[[wheel.place]] with radius_m, kind and plane  # below each [[wheel]] of " + file});
  if (findings.empty())
    findings.push_back(
        {"accuracy", Finding::kWell, file + " tells what grams, angles and their ± rest on.", ""});
  return findings;
}

}  // namespace roadbalance
