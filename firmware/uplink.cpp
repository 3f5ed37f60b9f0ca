#include "firmware/uplink.hpp"

#include <chrono>
#include <optional>

#include "common/bus/bus.hpp"
#include "common/bus/recorder_status.hpp"

namespace roadbalance {

namespace {

using namespace std::chrono_literals;
constexpr auto kIdleWait = 2ms;
constexpr auto kFarewell = 1s;  // told to stop, how long the owner may take to call the rest durable

}  // namespace

void uplink(std::stop_token stop, const std::string& bus_url, std::int32_t node, NodeLink& link,
            const std::function<void(const std::string&)>& warn) {
  Bus bus(bus_url);
  const auto take = [&link](std::string_view channel, std::span<const std::uint8_t> bytes) {
    link.take(channel, bytes, WallClock::now());
  };
  bus.subscribe(ack_channel(node), take);
  bus.subscribe(command_channel(node), take);
  // A recorder that does not understand this node says no more to it than to everybody.
  bus.subscribe(kRecorderChannel, [](std::string_view, std::span<const std::uint8_t>) {});
  const Publish publish = [&bus](const std::string& channel, std::span<const std::uint8_t> bytes) {
    return bus.publish(channel, bytes);
  };

  std::optional<WallTime> told_to_stop;
  while (!link.finished()) {
    const WallTime now = WallClock::now();
    if (stop.stop_requested() && !told_to_stop) told_to_stop = now;
    if (told_to_stop && (now - *told_to_stop > kFarewell || link.owner() == 0)) break;
    const bool busy = link.turn(now, publish);
    bus.handle(busy ? 0ms : kIdleWait);
    for (const std::string& sentence : bus.other_versions()) warn(sentence);
  }
  link.farewell(publish);
}

}  // namespace roadbalance
