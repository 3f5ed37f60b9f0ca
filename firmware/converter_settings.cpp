#include "firmware/converter_settings.hpp"

#include <cstdio>

#include "common/config/same_number.hpp"
#include "common/config/section.hpp"

namespace roadbalance {
namespace {

std::string in_m_s2(double range) {
  char text[32];
  std::snprintf(text, sizeof text, "%g m/s²", range);
  return text;
}

void check_range(const ChannelConfig& before, const ChannelConfig& after, ConverterSettings::Range range) {
  if (is_same_number(before.range_m_s2, after.range_m_s2) || range == ConverterSettings::Range::kByValue)
    return;
  const std::string what = "channel " + after.name + ": ";
  if (range == ConverterSettings::Range::kFixed)
    throw ConfigError(what + "its device has one range, " + in_m_s2(before.range_m_s2) +
                      "; for another sensor start rb-node anew with its vehicle.toml");
  if (!before.input_range_v || !after.input_range_v)
    throw ConfigError(what + "the board's range is a voltage: vehicle.toml must say input_range_v");
  if (!is_same_number(after.range_m_s2 / before.range_m_s2, *after.input_range_v / *before.input_range_v))
    throw ConfigError(what + "range_m_s2 does not go with input_range_v");
}

}  // namespace

ConverterSettings converter_settings(std::span<const std::string> addresses) {
  ConverterSettings settings;
  for (const std::string& address : addresses) {
    if (address.starts_with("sim:")) settings = {ConverterSettings::Range::kByValue, true};
    if (address.starts_with("usb:")) settings = {ConverterSettings::Range::kByVoltage, true};
  }
  return settings;
}

void check_change(const VehicleConfig& before, const VehicleConfig& after, const std::string& node_name,
                  const ConverterSettings& device) {
  if (!device.filter && (before.filter.order != after.filter.order ||
                         !is_same_number(before.filter.cutoff_hz, after.filter.cutoff_hz)))
    throw ConfigError("filter: the device of node " + node_name + " has one filter, which cannot be set");
  for (const ChannelConfig& was : before.node_named(node_name).channel)
    for (const ChannelConfig& is : after.node_named(node_name).channel)
      if (was.name == is.name) check_range(was, is, device.range);
}

}  // namespace roadbalance
