#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "common/bus/setup.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// The vehicle whose text has this CRC-32C; nothing: it is not here.
using VehicleByCrc = std::function<std::optional<VehicleConfig>(std::uint32_t crc32c)>;

/// Looks among the .toml files of a folder; files that are no vehicle are none.
VehicleByCrc vehicle_files_in(const std::filesystem::path& folder);

/// By which vehicle.toml the nodes measure now: between recordings another one can be chosen, or ranges and
/// zeros be changed (rb vehicle, configure, zero), and the last recording's vehicle holds no longer.
///
/// Every node reports once a second the CRC of the text that is in force (NodeSetup), the recorder's files
/// have the text.
class ChosenVehicle {
 public:
  /// @param now   of which is known what channels are
  /// @param find  may be empty: then nothing changes
  /// @param warn  hears of a text that is not found
  ChosenVehicle(const VehicleConfig& now, VehicleByCrc find, std::function<void(const std::string&)> warn);

  void take(const NodeSetup& setup, WallTime now);

  /// The other vehicle by which all nodes measure that are heard, once.  Nothing while they differ, as they
  /// do amid a change.
  std::optional<VehicleConfig> changed(WallTime now);

 private:
  struct Heard {
    WallTime at{};
    std::uint32_t crc32c = 0;
  };
  std::uint32_t crc32c_;
  VehicleByCrc find_;
  std::function<void(const std::string&)> warn_;
  std::map<std::int32_t, Heard> heard_;
  std::optional<std::uint32_t> not_found_;
  WallTime looked_at_{};
};

}  // namespace roadbalance
