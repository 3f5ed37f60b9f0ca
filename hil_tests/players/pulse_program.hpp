#pragma once

#include <cstdint>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "hil_tests/players/node_drive.hpp"

namespace roadbalance::test {

/// A level that a wire takes at an instant of the drive.
struct DriveLevel {
  NodeTime time{};
  std::uint16_t wire = 0;  ///< a number of the one who asked
  bool high = false;
};

/// One rising edge after the other as pulses: the level goes back in the middle between two edges, at the
/// latest after 100 us.  Edges that are lost in a recording are not played: a tooth is missing there.
class PulseProgram {
 public:
  /// @param teeth, marks  the wires of that line; no marks: they are left out
  void add(const NodeDrive& drive, std::uint8_t line, std::uint16_t teeth,
           std::optional<std::uint16_t> marks);

  /// Levels of all wires, in order of time.
  std::vector<DriveLevel> take();

 private:
  void add(const std::vector<NodeTime>& rises, std::uint16_t wire);
  std::vector<DriveLevel> levels_;
};

/// Refuses what these players do not do: wheels that turn backwards, and so second tracks.
/// @throws ConfigError naming the wheel or line
void check_playable(const VehicleConfig& vehicle, const NodeConfig& node, const NodeDrive& drive);

}  // namespace roadbalance::test
