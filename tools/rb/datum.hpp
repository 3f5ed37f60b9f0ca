#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/config/vehicle_config.hpp"
#include "host/calibration/datum_readings.hpp"

namespace roadbalance {

struct DatumOptions {
  std::string vehicle;  ///< file to set it in; empty: none
  std::string wheel;
  // By turning.
  std::string url;
  int readings = 5;
  double patience_s = 0;  ///< 0: for ever
  // By a trial weight.
  std::string before, after;  ///< recordings
  double grams = 0;
  std::string at;
  double at_sigma_deg = 2.0;
  std::optional<double> radius_m;  ///< where it is clipped; default: the weight radius
  bool dry_run = false;
  bool json = false;
};

/// What a calibration says; of `json` what is printed.
struct FoundDatum {
  double datum_rad;
  double sigma_rad;
  nlohmann::ordered_json json;
  std::string sentence;
};

/// Each says on standard error what stands in the way, and then returns nothing.
/// @throws ConfigError, or as the recordings and the bus do
std::optional<FoundDatum> datum_by_turning(const DatumOptions& options, const WheelConfig& wheel,
                                           const NodeConfig& node);
std::optional<FoundDatum> datum_by_weight(const DatumOptions& options);

/// @throws ConfigError naming the wheels that have a zero mark
const WheelConfig& wheel_with_mark(const VehicleConfig& vehicle, const std::string& name);

}  // namespace roadbalance
