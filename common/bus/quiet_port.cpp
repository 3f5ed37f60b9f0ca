#include "common/bus/quiet_port.hpp"

#include <chrono>
#include <stdexcept>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/process_port.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {
namespace {

constexpr int kMostTurns = 8;
/// Every node, idle or not, beats three times in it.
constexpr std::chrono::milliseconds kListen{300};

}  // namespace

bool is_quiet(const std::string& url, std::chrono::milliseconds listen) {
  Bus bus(url);
  bool heard = false;
  for (const char* channels :
       {"RB_BLOCK_.*", "RB_PREVIEW_.*", "RB_HEARTBEAT_.*", "RB_ACK_.*", "RB_COMMAND_.*", kRecorderChannel})
    bus.subscribe(channels, [&](std::string_view, std::span<const std::uint8_t>) { heard = true; });
  const WallTime end = WallClock::now() + listen;
  for (auto left = listen; left.count() > 0 && !heard;
       left = std::chrono::duration_cast<std::chrono::milliseconds>(end - WallClock::now()))
    bus.handle(left);
  return !heard;
}

int quiet_port(int asked) {
  if (asked != 0) {
    if (is_quiet(bus_url_on_port(asked), kListen)) return asked;
    throw std::runtime_error("another recorder or node is on port " + std::to_string(asked) +
                             " of the bus; --bus-port names another, without it a free one is taken");
  }
  for (int turn = 0; turn < kMostTurns; ++turn) {
    const int port = process_port(turn);
    try {
      if (is_quiet(bus_url_on_port(port), kListen)) return port;
    } catch (const std::runtime_error&) {
      if (turn + 1 == kMostTurns) throw;  // not this port: there is no bus on any
    }
  }
  throw std::runtime_error("on each of " + std::to_string(kMostTurns) +
                           " ports there is another recorder or node; --bus-port names one");
}

}  // namespace roadbalance
