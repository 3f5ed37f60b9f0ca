#include "host/analysis/drives/same_car.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "common/text/format.hpp"

namespace roadbalance {
namespace {

/// Keys with their values as text, in the order in which a person looks for a difference.
using Facts = std::vector<std::pair<std::string, std::string>>;

std::string text_of(double value) {
  return format("%.10g", value);
}

std::string text_of(const Eigen::Vector3d& v) {
  return format("[%.6g, %.6g, %.6g]", v.x(), v.y(), v.z());
}

const char* text_of(ChannelRole role) {
  switch (role) {
    case ChannelRole::kAcceleration:
      return "acceleration";
    case ChannelRole::kRoad:
      return "road";
    case ChannelRole::kUnused:
      return "unused";
  }
  return "unknown";
}

void add_model(const ModelConfig& model, Facts& facts) {
  const auto add = [&](const std::string& key, double value) {
    facts.emplace_back("model." + key, text_of(value));
  };
  facts.emplace_back("model.description", model.description.empty() ? "none" : model.description);
  add("body_mass_kg", model.body_mass_kg);
  add("roll_inertia_kg_m2", model.roll_inertia_kg_m2);
  add("pitch_inertia_kg_m2", model.pitch_inertia_kg_m2);
  add("body_mass_sigma_kg", model.body_mass_sigma_kg);
  add("roll_inertia_sigma_kg_m2", model.roll_inertia_sigma_kg_m2);
  add("pitch_inertia_sigma_kg_m2", model.pitch_inertia_sigma_kg_m2);
  for (std::size_t i = 0; i < kAxles; ++i) {
    const AxleConfig& axle = model.axle[i];
    const std::string at = i == 0 ? "front." : "rear.";
    add(at + "x_m", axle.x_m);
    add(at + "half_track_m", axle.half_track_m);
    add(at + "spring_n_m", axle.spring_n_m);
    add(at + "damper_n_s_m", axle.damper_n_s_m);
    add(at + "stabiliser_n_m", axle.stabiliser_n_m);
    add(at + "tyre_n_m", axle.tyre_n_m);
    add(at + "tyre_damper_n_s_m", axle.tyre_damper_n_s_m);
    add(at + "tyre_damper_sigma_n_s_m", axle.tyre_damper_sigma_n_s_m);
  }
}

std::string text_of(const std::vector<WheelWeight>& fitted) {
  std::vector<std::string> all;
  for (const WheelWeight& weight : fitted)
    all.push_back(format("%.10g g at %.6g deg on %.6g m", weight.mass_g,
                         weight.angle_rad * 180.0 / std::numbers::pi, weight.place.radius_m));
  std::sort(all.begin(), all.end());
  std::string text;
  for (const std::string& one : all) text += (text.empty() ? "" : ", ") + one;
  return text.empty() ? "none" : text;
}

void add_wheel(const WheelConfig& wheel, Facts& facts) {
  const std::string at = "wheel " + wheel.name + ": ";
  facts.emplace_back(at + "weight", text_of(wheel.fitted));
  const auto add = [&](const std::string& key, double value) {
    facts.emplace_back(at + key, text_of(value));
  };
  add("mass_kg", wheel.mass_kg);
  add("mass_sigma_kg", wheel.mass_sigma_kg);
  add("rolling_radius_m", wheel.rolling_radius_m);
  add("weight_radius_m", wheel.weight_radius_m);
  facts.emplace_back(at + "encoder", wheel.node.empty() ? "none" : "there");
  if (wheel.node.empty()) return;
  const double degrees = 180.0 / std::numbers::pi;
  facts.emplace_back(at + "zero_mark", wheel.encoder.zero_mark ? "true" : "false");
  facts.emplace_back(at + "datum_deg", text_of(wheel.encoder.datum_rad * degrees));
  facts.emplace_back(at + "datum_sigma_deg", text_of(wheel.encoder.datum_sigma_rad * degrees));
}

/// Channels of accelerations or roads, by their names: which converter reads them does not matter.
void add_channels(const VehicleConfig& vehicle, Facts& facts) {
  std::map<std::string, const ChannelConfig*> by_name;
  for (const NodeConfig& node : vehicle.node)
    for (const ChannelConfig& channel : node.channel)
      if (channel.role != ChannelRole::kUnused) by_name[node.name + "." + channel.name] = &channel;
  std::string names;
  for (const auto& [name, channel] : by_name) names += (names.empty() ? "" : ", ") + name;
  facts.emplace_back("node.channel", names);
  for (const auto& [name, channel] : by_name) {
    const std::string at = "channel " + name + ": ";
    facts.emplace_back(at + "role", text_of(channel->role));
    facts.emplace_back(at + "mount", channel->mount);
    facts.emplace_back(at + "position_m", text_of(channel->position_m));
    facts.emplace_back(at + "direction", text_of(channel->direction));
    facts.emplace_back(at + "gain_sigma", text_of(channel->gain_sigma));
  }
}

void add_drive(const VehicleConfig& vehicle, Facts& facts) {
  const auto add = [&](const std::string& key, double value) {
    facts.emplace_back("drive." + key, text_of(value));
  };
  add("section_s", vehicle.drive.section_s);
  add("speed_class_m_s", vehicle.drive.speed_class_m_s);
  add("least_speed_m_s", vehicle.drive.least_speed_m_s);
}

Facts facts_of(const VehicleConfig& vehicle) {
  Facts facts;
  for (const WheelConfig& wheel : vehicle.wheel) add_wheel(wheel, facts);
  add_model(vehicle.model, facts);
  add_channels(vehicle, facts);
  add_drive(vehicle, facts);
  return facts;
}

/// An imported recording's rate is fitted to its stamps.
constexpr double kSameRate = 1e-3;

}  // namespace

std::optional<std::string> difference_of_cars(const VehicleConfig& there, const VehicleConfig& here) {
  const Facts first = facts_of(there), second = facts_of(here);
  const auto difference = [](const std::string& key, const std::string& a, const std::string& b) {
    return key + ": " + a + " there, " + b + " here";
  };
  for (std::size_t i = 0; i < std::min(first.size(), second.size()); ++i) {
    if (first[i].first != second[i].first) break;  // the rest follows from the lists of names before
    if (first[i].second != second[i].second)
      return difference(first[i].first, first[i].second, second[i].second);
  }
  const double rate_hz = there.drive.identification_rate_hz, other_hz = here.drive.identification_rate_hz;
  if (std::abs(rate_hz - other_hz) > kSameRate * rate_hz)
    return difference("drive.identification_rate_hz", text_of(rate_hz), text_of(other_hz));
  return std::nullopt;
}

}  // namespace roadbalance
