#include "hil_tests/players/frame_program.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "common/config/section.hpp"
#include "common/dbc/wanted_signal.hpp"

namespace roadbalance::test {
namespace {

constexpr auto kOneFrame = std::chrono::microseconds(100);

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
  if (description.multiplexor())
    throw ConfigError("message " + description.name + ": is multiplexed, which is not played");
  messages_.push_back({interface, description});
  return messages_.size() - 1;
}

void FrameProgram::add(const VehicleConfig& vehicle, const NodeConfig& node, const NodeDrive& drive) {
  const std::size_t first = encodings_.size();
  for (const CanConfig& can : node.wiring.can) {
    if (can.signal.empty()) continue;
    const Dbc dbc = Dbc::read_file((std::filesystem::path(vehicle.folder) / can.dbc).string());
    for (const SignalConfig& wanted : can.signal) {
      const auto [message, signal, factor] = find_wanted(wanted, vehicle, dbc);
      encodings_.push_back(
          {message_of(interface_of(can.interface), *message), signal->place, factor, wanted.name});
    }
  }
  for (const SignalSample& sample : drive.signals) {
    const std::size_t encoding = first + sample.signal;
    if (encoding >= encodings_.size())
      throw ConfigError("drive of node " + node.name + ": has a signal number " +
                        std::to_string(sample.signal) + " that its vehicle.toml does not have");
    values_.push_back({sample.time, encoding, sample.value / encodings_[encoding].factor});
  }
}

std::vector<DriveFrame> FrameProgram::take() {
  std::ranges::stable_sort(values_, {}, &Value::time);
  std::vector<DriveFrame> frames;
  std::vector<CanFrame> sent(messages_.size());
  std::vector<std::ptrdiff_t> open(messages_.size(), -1);  // the message's last frame
  for (const Value& value : values_) {
    const SignalEncoding& encoding = encodings_[value.encoding];
    const Message& message = messages_[encoding.message];
    CanFrame& frame = sent[encoding.message];
    frame.id = message.description.id;
    frame.extended = message.description.extended;
    frame.size = static_cast<std::uint8_t>(message.description.size);
    frame.is_fd = message.description.size > kClassicCanBytes;
    if (!encoding.place.put(value.value, frame))
      throw ConfigError("signal \"" + encoding.name + "\": " + std::to_string(value.value) +
                        " cannot be said by message " + message.description.name);
    std::ptrdiff_t& last = open[encoding.message];
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
