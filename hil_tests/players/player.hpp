#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "hil_tests/players/board_player.hpp"
#include "hil_tests/players/frame_player.hpp"
#include "hil_tests/players/node_drive.hpp"
#include "hil_tests/players/pulse_player.hpp"
#include "hil_tests/players/usb_board/usb_boards.hpp"

namespace roadbalance::test {

/// Plays a drive into the devices of its nodes by vehicle.toml: for each node a front-end
/// board plugged into this machine's kernel, whose converter finds the drive's counts; pulses on the GPIO
/// lines of [[node.line]], or at the board's own inputs where there is none; frames on the interfaces of
/// [[node.can]].
class Player {
 public:
  struct Part {
    const NodeConfig& node;
    NodeDrive drive;
  };

  /// Plugs the boards in.  The drive begins after `lead`; until then the nodes must have been started.
  /// @throws ConfigError naming what of the vehicle cannot be played; what the devices throw
  Player(const VehicleConfig& vehicle, std::vector<Part> parts, std::chrono::duration<double> lead);

  /// Until the drive is over, or asked to stop.
  void run(std::stop_token stop);

  /// Counts of all that was played, one JSON object.
  std::string report() const;
  /// Why not everything was played; empty: everything was.
  std::string shortfall() const;

 private:
  struct Node {
    std::string name;
    std::int64_t scans;
    double converter_ppm;
    std::unique_ptr<BoardPlayer> player;
  };
  Node prepare(const VehicleConfig& vehicle, Part part, PulseProgram& pulses, FrameProgram& frames);

  MachineTime begin_{};
  NodeTime first_ = NodeTime::max(), last_ = NodeTime::min();
  std::vector<Bench> bench_;
  std::vector<Node> node_;
  std::optional<PulsePlayer> pulses_;
  std::size_t pulses_wanted_ = 0;
  std::optional<FramePlayer> frames_;
  std::size_t frames_wanted_ = 0;
  std::optional<UsbBoards> boards_;  ///< gone before what its boards show
};

}  // namespace roadbalance::test
