#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/config/counter_form.hpp"
#include "common/config/section.hpp"

namespace roadbalance {

/// The meaning of a signal, and so the unit its samples have in the record.
enum class SignalQuantity {
  kWheelSpeed,     ///< m/s at the tread; a speed of rotation times the rolling radius
  kVehicleSpeed,   ///< m/s
  kSteeringAngle,  ///< rad, of the steering wheel, left positive
  kPulseCounter,   ///< pulses of a wheel's ring, wrapping
  kOther,          ///< as the car's description gives it
};

/// As vehicle.toml calls it: "wheel_speed".
const char* name_of(SignalQuantity quantity);

/// [[node.can.signal]]: a number that a device of the car sends.
struct SignalConfig {
  std::string name;
  std::string message, signal;  ///< as the DBC file calls them
  SignalQuantity quantity = SignalQuantity::kOther;
  std::string wheel;  ///< which, for wheel_speed and pulse_counter; else empty
  // [node.can.signal.counter], of a pulse_counter
  CounterForm counter{};
  CounterLatency latency{};
};

enum class CanRole {
  kVehicle,  ///< the car's own bus: we listen only, and the interface must be listen-only
  kSensor,   ///< a private bus with our modules, whose frames need an acknowledgement
};

/// An accelerometer module of classic frames has its identifier and the three behind it.
inline constexpr std::uint32_t kHighestAccelerometerId = 0x7FF - 3;

/// [[node.can]]: a CAN interface that the node listens to.
struct CanConfig {
  std::string interface;  ///< "can0"
  CanRole role = CanRole::kVehicle;
  std::string dbc;  ///< file that describes its frames; empty: none
  /// First identifier of an accelerometer module; role sensor.
  std::optional<std::uint32_t> accelerometer_id;
  std::vector<SignalConfig> signal;
  int first_signal = 0;  ///< number of signal[0] among the node's signals
};

/// [[node.line]]: how an encoder is wired to GPIO.
struct LineConfig {
  int line = 0;                       ///< of the node, as WheelConfig::line
  int tooth_gpio = 0;                 ///< offset of its line on the chip
  std::optional<int> direction_gpio;  ///< second track of a transducer in quadrature
  std::optional<int> zero_mark_gpio;
};

/// The part of [[node]] that names the devices connected to it, and how.
struct NodeWiring {
  /// URIs: one device that gives scans, and any that give what is beside.
  std::vector<std::string> front_end;
  bool loop_back = false;  ///< channels 13 .. 16 come from the converter, not from computation
  std::vector<CanConfig> can;
  std::vector<LineConfig> line;  ///< at most kEncoderLines

  std::size_t signals() const;
  /// Signal of that number (SignalSample::signal); nullptr if there is none.
  const SignalConfig* signal(int number) const;
  /// Wiring of an encoder line to GPIO; nullptr: it has none.
  const LineConfig* line_at(int number) const;
  /// Takes its keys of the table.
  /// @param wheels  names of the wheels there are
  /// @throws ConfigError
  static NodeWiring take(Section& node, const std::vector<std::string>& wheels);
};

}  // namespace roadbalance
