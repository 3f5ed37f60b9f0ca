#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/recording/formats/sample_source.hpp"

namespace roadbalance {

/// A person's word on the numbers of a file, which counts more than the file's: for all channels ("g",
/// "100mV/g") or for one ("body_z=g", "body_z=10.2mV/(m/s^2)").  A sensitivity for all is of the channels
/// that are in volts or have no unit.
struct UnitOptions {
  std::vector<std::string> units = {};
  std::vector<std::string> sensitivity = {};
};

/// A column of a file as it is understood.
struct ChannelUnit {
  std::string channel = {};
  std::string in_file = {};  ///< printable, as it stands there; empty: the file has no unit
  double factor = 1.0;       ///< from the file's numbers to m/s^2, of channels with role road to m
  std::string meaning = {};  ///< a clause in English: "9.80665 m/s^2 each"; empty: the channel is not read
};

/// One for each column.  Without a unit in the file, and without a person's word, SI is assumed, and
/// reported.
/// @throws ConfigError naming the option, or the file and channel: a unit that is not known, that is none of
/// an
///         acceleration (of a length for role road), or volts without a sensitivity
std::vector<ChannelUnit> understand_units(const std::filesystem::path& file,
                                          const std::vector<FileChannel>& columns,
                                          const VehicleConfig& vehicle, const UnitOptions& options);

}  // namespace roadbalance
