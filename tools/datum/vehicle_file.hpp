#pragma once

#include <string>
#include <vector>

#include "common/config/set_value.hpp"

namespace roadbalance {

struct ValueToSet {
  TablePath table;
  std::string key;
  std::string value;  ///< as TOML writes it
};

/// Sets values in a vehicle.toml, and changes nothing else in it.  The file is read anew, so that what was
/// written to it since a long measurement began is kept; the one before is kept beside it as PATH.bak.
/// A reader sees the old file or the new one, never a part.
/// @throws ConfigError if a value has no place in it or the new file could not be used: then nothing is
///         written; std::system_error naming the file
void set_in_vehicle_file(const std::string& path, const std::vector<ValueToSet>& values);

/// Refuses now what could not be written at the end of a measurement.
/// @throws as set_in_vehicle_file
void check_vehicle_file(const std::string& path, const std::vector<ValueToSet>& values);

}  // namespace roadbalance
