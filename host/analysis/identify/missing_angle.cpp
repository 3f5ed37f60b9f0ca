#include "host/analysis/identify/missing_angle.hpp"

#include <algorithm>

namespace roadbalance {
namespace {

bool bus_tells(const VehicleConfig& vehicle, const WheelConfig& wheel, SignalQuantity quantity) {
  const auto is_it = [&](const SignalConfig& signal) {
    return signal.quantity == quantity && signal.wheel == wheel.name;
  };
  for (const NodeConfig& node : vehicle.node)
    for (const CanConfig& can : node.wiring.can)
      if (std::ranges::any_of(can.signal, is_it)) return true;
  return false;
}

void append(std::string& list, const std::string& name, const char* between) {
  list += (list.empty() ? "" : between) + name;
}

}  // namespace

std::string why_no_angle(const VehicleConfig& vehicle) {
  std::string speed, counter, teeth;
  bool any = false;
  for (const WheelConfig& wheel : vehicle.wheel) {
    any = any || !wheel.node.empty();
    if (!wheel.node.empty()) {
      if (!wheel.encoder.zero_mark) append(wheel.encoder.counter.empty() ? teeth : counter, wheel.name, ", ");
      continue;
    }
    if (bus_tells(vehicle, wheel, SignalQuantity::kPulseCounter))
      append(counter, wheel.name, ", ");
    else if (bus_tells(vehicle, wheel, SignalQuantity::kWheelSpeed))
      append(speed, wheel.name, ", ");
  }
  std::string why;
  if (!speed.empty())
    append(why,
           speed +
               ": the bus tells the wheel's speed only; a speed gives orders and magnitudes but carries no "
               "angle, "
               "so no place for a weight",
           "; ");
  if (!counter.empty())
    append(why,
           counter +
               ": the bus counts pulses but sends no zero mark, and none is on a line; a count is an angle "
               "turned through, not the "
               "wheel's angle",
           "; ");
  if (!teeth.empty())
    append(
        why,
        teeth +
            ": its encoder has no zero mark; teeth tell how far the wheel has turned, not the wheel's angle",
        "; ");
  if (why.empty() && !any)
    why = "no wheel has an encoder, and the bus tells nothing of the wheels: there is no angle";
  return why;
}

}  // namespace roadbalance
