#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/operation.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/record/disk.hpp"
#include "common/types/blocks.hpp"
#include "common/types/clocks.hpp"
#include "host/recorder/control/standstill_readings.hpp"
#include "host/recorder/control/turn_over.hpp"

namespace roadbalance {

/// Thrown: a request cannot be obeyed.
struct SetUpRefusal {
  RefusalReason reason = RefusalReason::kNone;
  std::string why;
};

/// Makes the vehicle.toml that a request asks for, from the one in force and from readings of the nodes'
/// preview blocks.  A zero needs a car that stands, as StandstillReadings judges it: no reference turns, and
/// no channel shakes.  A scale by gravity needs the same twice: the sensor's arrow up, then down.
class RequestedVehicle {
 public:
  explicit RequestedVehicle(Disk& disk) : disk_(disk) {}

  void take(const ScanBlock& preview, WallTime now) { readings_.take(preview, now); }

  struct Wanted {
    std::filesystem::path file;         ///< that is in force then
    std::optional<std::string> text{};  ///< of it; nothing: there is nothing to change yet
    std::string words{};                ///< for people: what is done then, or what is next
  };
  /// @param file   vehicle.toml in force; those beside it can be chosen
  /// @param text   of it
  /// @param nodes  that are there
  /// @throws SetUpRefusal, ConfigError, std::system_error
  Wanted find(const Request& request, const std::filesystem::path& file, const std::string& text,
              const std::vector<std::int32_t>& nodes, WallTime now);
  /// Another range or scale is in force: earlier readings mean something else.
  void forget() { turn_over_.forget(); }

 private:
  using Readings = std::map<int, StandstillReadings::Reading>;
  Readings standstill(const Request& request, const VehicleConfig& vehicle,
                      const std::vector<std::int32_t>& nodes, WallTime now) const;
  Wanted scaled(const Request& request, Wanted wanted, const std::string& text, const VehicleConfig& vehicle,
                const std::vector<std::int32_t>& nodes, WallTime now);

  Disk& disk_;
  StandstillReadings readings_;
  TurnOver turn_over_;
};

/// For people: the result of a set-up other than Operation::kScale.
std::string what_is_done(const Request& request, const std::filesystem::path& file);

/// It can be chosen: a name without folders that ends in .toml.
bool is_vehicle_file_name(const std::string& name);

/// @throws std::system_error, also if there is none
std::string read_vehicle_file(const std::filesystem::path& file, Disk& disk);

}  // namespace roadbalance
