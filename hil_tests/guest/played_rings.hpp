#pragma once

#include <array>

#include "common/config/vehicle_config.hpp"
#include "hil_tests/guest/pulse_chip.hpp"
#include "hil_tests/guest/ring_judge.hpp"

namespace roadbalance::test {

/// The rings of a node's two wheels on the guest's chip: teeth at GPIO 3 and 5, zero marks at 4 and 6.
class PlayedRings {
 public:
  static constexpr std::array<double, kEncoderLines> kTurns_hz{10.0, 11.3};
  /// As [[node.line]] of a vehicle.toml.
  static constexpr const char* kWiring =
      "[[node.line]]\nline = 0\ntooth_gpio = 3\nzero_mark_gpio = 4\n"
      "[[node.line]]\nline = 1\ntooth_gpio = 5\nzero_mark_gpio = 6\n";

  /// Both wheels turn evenly from soon on.
  /// @param vehicle  whose first two wheels these are
  /// @param seconds  longer than the measurement: what is not needed is forgotten
  void turn(const VehicleConfig& vehicle, double seconds);

  /// [line]
  const std::array<JudgedRing, kEncoderLines>& all() const { return rings_; }

 private:
  PulseChip chip_;
  std::array<JudgedRing, kEncoderLines> rings_;
};

}  // namespace roadbalance::test
