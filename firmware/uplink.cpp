#include "firmware/uplink.hpp"

#include <chrono>
#include <exception>
#include <optional>
#include <thread>

#include "common/bus/recorder_status.hpp"
#include "common/frontend/lasting_reason.hpp"

namespace roadbalance {

namespace {

using namespace std::chrono_literals;
constexpr auto kIdleWait = 5ms;  // a block takes 10 ms to fill; what comes from the bus wakes at once
constexpr auto kAskAgain = 1s;
constexpr auto kFarewell = 1s;  // asked to stop, how long the owner may take to call the others durable

}  // namespace

std::unique_ptr<Bus> open_node_bus(const std::string& url, std::int32_t node, NodeLink& link) {
  auto bus = std::make_unique<Bus>(url);
  const auto take = [&link](std::string_view channel, std::span<const std::uint8_t> bytes) {
    link.take(channel, bytes, WallClock::now());
  };
  bus->subscribe(ack_channel(node), take);
  bus->subscribe(command_channel(node), take);
  bus->subscribe(vehicle_channel(node), take);
  // A recorder that does not understand this node sends no more to it than to all.
  bus->subscribe(kRecorderChannel, [](std::string_view, std::span<const std::uint8_t>) {});
  return bus;
}

void uplink(std::stop_token stop, const std::function<std::unique_ptr<Bus>()>& open, NodeLink& link,
            const std::function<void(const std::string&)>& warn) {
  std::unique_ptr<Bus> bus = open();
  const Publish publish = [&bus](const std::string& channel, std::span<const std::uint8_t> bytes) {
    return bus && bus->publish(channel, bytes);
  };
  // A bus that fails later costs the link, not the measurement.
  WallTime ask_again{};
  LastingReason lost;

  std::optional<WallTime> stop_asked_at;
  while (!link.finished()) {
    const WallTime now = WallClock::now();
    if (stop.stop_requested() && !stop_asked_at) stop_asked_at = now;
    if (stop_asked_at && (now - *stop_asked_at > kFarewell || link.owner() == 0)) break;
    if (!bus && now < ask_again) {
      link.relieve(now);
      std::this_thread::sleep_for(kIdleWait);
      continue;
    }
    bool busy = false;
    if (bus) {
      bus->gather(kBlockChannels);
      busy = link.turn(now, publish);
      link.count_unsent(bus->send_gathered());
    }
    try {
      if (!bus) bus = open();
      bus->handle(busy ? 0ms : kIdleWait);
      lost.over();
      for (const std::string& sentence : bus->other_versions()) warn(sentence);
    } catch (const std::exception& error) {
      bus.reset();
      ask_again = now + kAskAgain;
      if (lost.is_due(error.what(), now))
        warn(std::string(error.what()) + "; sampling goes on, the bus is tried again");
    }
  }
  link.farewell(publish);
}

}  // namespace roadbalance
