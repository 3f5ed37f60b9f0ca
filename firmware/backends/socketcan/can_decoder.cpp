#include "firmware/backends/socketcan/can_decoder.hpp"

#include <algorithm>
#include <cassert>
#include <string>

#include "common/config/section.hpp"
#include "firmware/backends/dbc/dbc_reading.hpp"
#include "firmware/backends/dbc/si_unit.hpp"

namespace roadbalance {
namespace {

double rolling_radius_m(const VehicleConfig& vehicle, const std::string& wheel) {
  const auto found = std::ranges::find(vehicle.wheel, wheel, &WheelConfig::name);
  assert(found != vehicle.wheel.end());  // the wiring was checked
  return found->rolling_radius_m;
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

CanDecoder::CanDecoder(const CanConfig& can, const VehicleConfig& vehicle, const Dbc& dbc) {
  int number = can.first_signal;
  for (const SignalConfig& wanted : can.signal) {
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
    Message& place = message_of(*message);
    if (place.wanted.size() == kMostOfOneFrame)
      throw ConfigError(line + " has more than 64 signals that are wanted");
    place.wanted.push_back({.in_message = static_cast<std::size_t>(signal - message->signals.data()),
                            .number = static_cast<std::uint16_t>(number++),
                            .factor = *to_quantity});
  }
}

CanDecoder::Message& CanDecoder::message_of(const DbcMessage& description) {
  const CanId id{description.id, description.extended};
  const auto found = std::ranges::find(messages_, id, &Message::id);
  if (found != messages_.end()) return *found;
  return messages_.emplace_back(Message{.id = id, .description = description, .wanted = {}});
}

std::vector<CanId> CanDecoder::ids() const {
  std::vector<CanId> ids;
  for (const Message& message : messages_) ids.push_back(message.id);
  return ids;
}

bool CanDecoder::needs_flexible() const {
  return std::ranges::any_of(
      messages_, [](const Message& message) { return message.description.size > kClassicCanBytes; });
}

CanDecoder::Decoded CanDecoder::decode(const CanFrame& frame, NodeTime time,
                                       std::span<SignalSample> samples) const noexcept {
  Decoded decoded;
  const auto message = std::ranges::find(messages_, CanId{frame.id, frame.extended}, &Message::id);
  if (message == messages_.end()) return decoded;
  assert(samples.size() >= message->wanted.size());
  for (const Wanted& wanted : message->wanted) {
    const DbcReading reading =
        read_signal(message->description, message->description.signals[wanted.in_message], frame);
    if (reading.status == DbcReading::Status::kOk)
      samples[decoded.samples++] = {
          .time = time, .signal = wanted.number, .value = reading.value * wanted.factor};
    else if (reading.status != DbcReading::Status::kAbsent)
      decoded.refused = true;
  }
  return decoded;
}

}  // namespace roadbalance
