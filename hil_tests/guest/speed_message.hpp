#pragma once

#include <cstdint>
#include <string>

#include "common/dbc/can_frame.hpp"

namespace roadbalance::test {

/// A car's message whose first two bytes are a speed, in steps of 0.01 km/h.
struct SpeedMessage {
  static constexpr const char* kDbc =
      "BO_ 170 Wheels: 8 X\n SG_ Left : 7|16@0+ (0.01,0) [0|300] \"km/h\" X\n";
  /// Keys and tables of [[node.can]], where car.dbc holds kDbc.
  static constexpr const char* kSignal =
      "dbc = \"car.dbc\"\n[[node.can.signal]]\nname = \"speed\"\nmessage = \"Wheels\"\nsignal = \"Left\"\n"
      "quantity = \"vehicle_speed\"\n";

  static CanFrame frame(std::uint16_t steps) {
    CanFrame frame{.id = 170, .size = 8};
    frame.data[0] = static_cast<std::uint8_t>(steps >> 8);
    frame.data[1] = static_cast<std::uint8_t>(steps);
    return frame;
  }
};

}  // namespace roadbalance::test
