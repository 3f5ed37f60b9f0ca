#include "common/dbc/wanted_signal.hpp"

#include <cassert>
#include <optional>
#include <string>
#include <string_view>

#include "common/config/section.hpp"
#include "common/dbc/si_unit.hpp"

namespace roadbalance {
namespace {

double rolling_radius_m(const VehicleConfig& vehicle, const std::string& name) {
  const WheelConfig* const wheel = vehicle.wheel_named(name);
  assert(wheel);  // the wiring was checked
  return wheel->rolling_radius_m;
}

/// From the unit of the DBC file to that of the quantity; nothing if they do not go together.
std::optional<double> factor(const SignalConfig& wanted, const std::string& unit,
                             const VehicleConfig& vehicle) {
  if (wanted.quantity == SignalQuantity::kOther) return 1.0;
  const auto si = si_unit(unit);
  if (!si) return std::nullopt;
  const std::string_view name = si->name;
  switch (wanted.quantity) {
    case SignalQuantity::kWheelSpeed:
      if (name == "rad/s") return si->factor * rolling_radius_m(vehicle, wanted.wheel);
      [[fallthrough]];
    case SignalQuantity::kVehicleSpeed:
      return name == "m/s" ? std::optional(si->factor) : std::nullopt;
    case SignalQuantity::kSteeringAngle:
      return name == "rad" ? std::optional(si->factor) : std::nullopt;
    case SignalQuantity::kPulseCounter:
      return name.empty() ? std::optional(si->factor) : std::nullopt;
    case SignalQuantity::kOther:
      break;
  }
  return std::nullopt;
}

const char* allowed_units(SignalQuantity quantity) {
  switch (quantity) {
    case SignalQuantity::kWheelSpeed:
      return "km/h, kph, mph, m/s, rpm, 1/min, rad/s, deg/s";
    case SignalQuantity::kVehicleSpeed:
      return "km/h, kph, mph, m/s";
    case SignalQuantity::kSteeringAngle:
      return "deg, rad";
    case SignalQuantity::kPulseCounter:
    case SignalQuantity::kOther:
      break;
  }
  return "none";
}

}  // namespace

WantedSignal find_wanted(const SignalConfig& wanted, const VehicleConfig& vehicle, const Dbc& dbc) {
  const std::string name = "signal \"" + wanted.name + "\": ";
  const DbcMessage* const message = dbc.message(wanted.message);
  if (!message) throw ConfigError(name + dbc.file + " has no message " + wanted.message);
  const std::string line =
      name + dbc.file + ":" + std::to_string(message->line) + ": message " + message->name;
  const DbcSignal* const signal = message->signal(wanted.signal);
  if (!signal) throw ConfigError(line + " has no signal " + wanted.signal);
  if (message->size > kLongestCanBytes)
    throw ConfigError(line + " has " + std::to_string(message->size) + " bytes; allowed: 64, one frame");
  const auto to_quantity = factor(wanted, signal->unit, vehicle);
  if (!to_quantity)
    throw ConfigError(name + dbc.file + ":" + std::to_string(signal->line) + ": " + signal->name +
                      " has unit \"" + signal->unit +
                      "\"; allowed for its quantity: " + allowed_units(wanted.quantity));
  return {.message = message, .signal = signal, .factor = *to_quantity};
}

}  // namespace roadbalance
