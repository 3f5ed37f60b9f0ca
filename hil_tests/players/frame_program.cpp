#include "hil_tests/players/frame_program.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "common/config/section.hpp"
#include "firmware/backends/dbc/si_unit.hpp"

namespace roadbalance::test {
namespace {

constexpr auto kOneFrame = std::chrono::microseconds(100);

/// The DBC file's unit, in that of the quantity.
double unit_of(const SignalConfig& wanted, const DbcSignal& signal, const VehicleConfig& vehicle) {
  if (wanted.quantity == SignalQuantity::kOther) return 1.0;
  const auto unit = si_unit(signal.unit);
  if (!unit)
    throw ConfigError("signal \"" + wanted.name + "\": its unit \"" + signal.unit + "\" cannot be played");
  if (std::string_view(unit->name) != "rad/s") return unit->factor;
  const auto wheel = std::ranges::find(vehicle.wheel, wanted.wheel, &WheelConfig::name);
  if (wheel == vehicle.wheel.end())
    throw ConfigError("signal \"" + wanted.name + "\": has unit \"" + signal.unit + "\", but no wheel");
  return unit->factor * wheel->rolling_radius_m;
}

}  // namespace

std::size_t FrameProgram::interface_of(const std::string& name) {
  const auto found = std::ranges::find(interfaces_, name);
  if (found == interfaces_.end()) interfaces_.push_back(name);
  return static_cast<std::size_t>(std::ranges::find(interfaces_, name) - interfaces_.begin());
}

std::size_t FrameProgram::message_of(std::size_t interface, const DbcMessage& description) {
  const auto same = [&](const Message& message) {
    return message.interface == interface && message.description.id == description.id &&
           message.description.extended == description.extended;
  };
  const auto found = std::ranges::find_if(messages_, same);
  if (found != messages_.end()) return static_cast<std::size_t>(found - messages_.begin());
  if (description.selector())
    throw ConfigError("message " + description.name + ": is multiplexed, which is not played");
  messages_.push_back({interface, description});
  return messages_.size() - 1;
}

void FrameProgram::add(const VehicleConfig& vehicle, const NodeConfig& node, const NodeDrive& drive) {
  const std::size_t first = ways_.size();
  for (const CanConfig& can : node.wiring.can) {
    if (can.signal.empty()) continue;
    const Dbc dbc = Dbc::read_file((std::filesystem::path(vehicle.folder) / can.dbc).string());
    for (const SignalConfig& wanted : can.signal) {
      const DbcMessage* message = dbc.message(wanted.message);
      const DbcSignal* signal = message ? message->signal(wanted.signal) : nullptr;
      if (!signal)
        throw ConfigError("signal \"" + wanted.name + "\": " + dbc.file + " has no signal " + wanted.signal +
                          " of a message " + wanted.message);
      ways_.push_back({message_of(interface_of(can.interface), *message), signal->place,
                       unit_of(wanted, *signal, vehicle), wanted.name});
    }
  }
  for (const SignalSample& sample : drive.signals) {
    const std::size_t way = first + sample.signal;
    if (way >= ways_.size())
      throw ConfigError("drive of node " + node.name + ": has a signal number " +
                        std::to_string(sample.signal) + " that its vehicle.toml does not have");
    values_.push_back({sample.time, way, sample.value / ways_[way].unit});
  }
}

std::vector<DriveFrame> FrameProgram::take() {
  std::ranges::stable_sort(values_, {}, &Value::time);
  std::vector<DriveFrame> frames;
  std::vector<CanFrame> said(messages_.size());
  std::vector<std::ptrdiff_t> open(messages_.size(), -1);  // the message's last frame
  for (const Value& value : values_) {
    const Way& way = ways_[value.way];
    const Message& message = messages_[way.message];
    CanFrame& frame = said[way.message];
    frame.id = message.description.id;
    frame.extended = message.description.extended;
    frame.size = static_cast<std::uint8_t>(message.description.size);
    frame.flexible = message.description.size > kClassicCanBytes;
    if (!way.place.put(value.value, frame))
      throw ConfigError("signal \"" + way.name + "\": " + std::to_string(value.value) +
                        " cannot be said by message " + message.description.name);
    std::ptrdiff_t& last = open[way.message];
    if (last >= 0 && value.time - frames[static_cast<std::size_t>(last)].time < kOneFrame) {
      frames[static_cast<std::size_t>(last)].frame = frame;
      continue;
    }
    last = static_cast<std::ptrdiff_t>(frames.size());
    frames.push_back({value.time, message.interface, frame});
  }
  values_.clear();
  return frames;
}

}  // namespace roadbalance::test
