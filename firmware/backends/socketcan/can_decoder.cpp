#include "firmware/backends/socketcan/can_decoder.hpp"

#include <algorithm>
#include <cassert>
#include <string>

#include "common/config/section.hpp"
#include "common/dbc/dbc_reading.hpp"
#include "common/dbc/wanted_signal.hpp"

namespace roadbalance {

CanDecoder::CanDecoder(const CanConfig& can, const VehicleConfig& vehicle, const Dbc& dbc) {
  int number = can.first_signal;
  for (const SignalConfig& wanted : can.signal) {
    const auto [message, signal, factor] = find_wanted(wanted, vehicle, dbc);
    Message& place = message_of(*message);
    if (place.wanted.size() == kMostOfOneFrame)
      throw ConfigError("signal \"" + wanted.name + "\": " + dbc.file + ":" + std::to_string(message->line) +
                        ": message " + message->name + " has more than 64 signals that are wanted");
    place.wanted.push_back({.in_message = static_cast<std::size_t>(signal - message->signals.data()),
                            .number = static_cast<std::uint16_t>(number++),
                            .factor = factor});
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

bool CanDecoder::needs_fd() const {
  return std::ranges::any_of(
      messages_, [](const Message& message) { return message.description.size > kClassicCanBytes; });
}

std::size_t CanDecoder::decode(const CanFrame& frame, NodeTime time, std::span<SignalSample> samples,
                               DeviceReport& report) const noexcept {
  std::size_t count = 0;
  bool refused = false;
  const auto message = std::ranges::find(messages_, CanId{frame.id, frame.extended}, &Message::id);
  if (message == messages_.end()) return count;
  assert(samples.size() >= message->wanted.size());
  for (const Wanted& wanted : message->wanted) {
    const DbcReading reading =
        read_signal(message->description, message->description.signals[wanted.in_message], frame);
    if (reading.status == DbcReading::Status::kOk)
      samples[count++] = {.time = time, .signal = wanted.number, .value = reading.value * wanted.factor};
    else if (reading.status != DbcReading::Status::kAbsent)
      refused = true;
  }
  if (refused) report.count(DeviceCounter::kFramesRefused);
  return count;
}

}  // namespace roadbalance
