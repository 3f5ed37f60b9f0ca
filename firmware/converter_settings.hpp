#pragma once

#include <span>
#include <string>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The settings of vehicle.toml that the device which converts a node's samples follows when it is opened
/// anew.  A range or filter in the file that the device does not have would make every acceleration wrong,
/// and nothing would show it.
struct ConverterSettings {
  enum class Range {
    kFixed,
    kByValue,    ///< range_m_s2 sets it
    kByVoltage,  ///< input_range_v sets it, and range_m_s2 goes with it
  };
  Range range = Range::kFixed;
  bool filter = false;
};

/// For the devices at these addresses: sim: follows everything, usb: voltages and filter, as far as it has
/// them; sensors on a CAN bus and recordings are as they are.
ConverterSettings converter_settings(std::span<const std::string> addresses);

/// @throws ConfigError naming the part of `after`, for a channel or the filter, that the device of this node
///         cannot do
void check_change(const VehicleConfig& before, const VehicleConfig& after, const std::string& node_name,
                  const ConverterSettings& device);

}  // namespace roadbalance
