#include "host/recorder/control/vehicle_edit.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>

#include "common/config/same_number.hpp"
#include "common/config/section.hpp"
#include "common/config/set_value.hpp"
#include "common/config/vehicle_config.hpp"
#include "host/analysis/calibration/datum_readings.hpp"
#include "host/recorder/control/mark_readings.hpp"

namespace roadbalance {
namespace {

constexpr const char* kFile = "vehicle.toml";
constexpr double kFullScale = 1 << 23;

// As many digits as a double needs to be read as the same.
std::string exact(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  std::string number = text;
  if (number.find_first_of(".en") == std::string::npos) number += ".0";
  return number;
}

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

TablePath path_of(const NodeConfig& node, const ChannelConfig& channel) {
  return {{"node", node.name}, {"channel", channel.name}};
}

TablePath calibration_of(const NodeConfig& node, const ChannelConfig& channel) {
  TablePath path = path_of(node, channel);
  path.push_back({"calibration"});
  return path;
}

}  // namespace

std::string with_range(const std::string& text, const Request& request) {
  const VehicleConfig vehicle = VehicleConfig::parse(text, kFile);
  const NodeConfig* node = vehicle.node_with_id(request.node);
  if (!node) throw ConfigError("there is no node " + std::to_string(request.node) + " in " + kFile);
  const auto k = static_cast<std::size_t>(request.channel);
  if (request.channel < 0 || k >= node->channel.size())
    throw ConfigError("node " + node->name + " has no channel " + std::to_string(request.channel + 1));
  const ChannelConfig& channel = node->channel[k];
  const double range = request.value[0];
  if (!(range > 0)) throw ConfigError("a range is above 0 m/s²");
  const double ratio = range / channel.range_m_s2;
  const TablePath path = path_of(*node, channel);
  std::string changed = with_value(text, path, "range_m_s2", number(range), kFile);
  if (channel.input_range_v)
    changed = with_value(changed, path, "input_range_v", number(*channel.input_range_v * ratio), kFile);
  // Values that the file does not give follow from the range; those that it gives must follow it.
  const ChannelConfig is = VehicleConfig::parse(changed, kFile).node_with_id(node->id)->channel[k];
  const TablePath calibration = calibration_of(*node, channel);
  if (!is_same_number(is.scale_m_s2_per_count, channel.scale_m_s2_per_count * ratio))
    changed = with_value(changed, calibration, "scale_m_s2_per_count",
                         exact(channel.scale_m_s2_per_count * ratio), kFile);
  if (!is_same_number(is.offset_counts, channel.offset_counts / ratio))
    changed = with_value(changed, calibration, "offset_counts", exact(channel.offset_counts / ratio), kFile);
  return changed;
}

std::string with_calibration(const std::string& text, const NodeConfig& node, int channel,
                             const TurnOver::Calibration& calibration) {
  const TablePath path = calibration_of(node, node.channel[static_cast<std::size_t>(channel)]);
  const std::string scaled =
      with_value(text, path, "scale_m_s2_per_count", exact(calibration.scale_m_s2_per_count), kFile);
  return with_value(scaled, path, "offset_counts", toml_number(calibration.offset_counts, 1), kFile);
}

std::string with_datum(const std::string& text, const Request& request) {
  constexpr double kTurn_rad = 2.0 * std::numbers::pi;
  const VehicleConfig vehicle = VehicleConfig::parse(text, kFile);
  const WheelConfig& wheel = wheel_with_mark(vehicle, request.channel);
  const auto [datum_rad, sigma_rad] = request.value;
  if (!(std::abs(datum_rad) <= kTurn_rad)) throw ConfigError("a datum is at most a turn");
  if (!(sigma_rad > 0.0 && sigma_rad <= std::numbers::pi))
    throw ConfigError("how well a datum is known is above 0 and at most half a turn");
  const TablePath encoder{{"wheel", wheel.name}, {"encoder"}};
  const DatumText words = datum_text(datum_rad, sigma_rad);
  return with_value(with_value(text, encoder, "datum_deg", words.datum_deg, kFile), encoder,
                    "datum_sigma_deg", words.datum_sigma_deg, kFile);
}

std::string with_filter(const std::string& text, const Request& request) {
  std::string changed = with_value(text, {{"filter"}}, "cutoff_hz", number(request.value[0]), kFile);
  if (request.value[1] != 0)
    changed = with_value(changed, {{"filter"}}, "order", number(request.value[1]), kFile);
  return changed;
}

std::string with_zero(const std::string& text, const std::map<int, StandstillReadings::Reading>& readings) {
  const VehicleConfig vehicle = VehicleConfig::parse(text, kFile);
  std::string changed = text;
  for (const NodeConfig& node : vehicle.node) {
    const auto reading = readings.find(node.id);
    if (reading == readings.end()) continue;
    for (std::size_t k = 0; k < node.channel.size(); ++k) {
      const ChannelConfig& channel = node.channel[k];
      if (channel.role != ChannelRole::kAcceleration) continue;
      const TablePath calibration = calibration_of(node, channel);
      // A calibration has its scale; where there is none yet it is that of the range.
      if (is_same_number(channel.scale_m_s2_per_count, channel.range_m_s2 / kFullScale))
        changed = with_value(changed, calibration, "scale_m_s2_per_count",
                             exact(channel.scale_m_s2_per_count), kFile);
      changed = with_value(changed, calibration, "offset_counts",
                           toml_number(reading->second.mean_counts[k], 1), kFile);
    }
  }
  return changed;
}

}  // namespace roadbalance
