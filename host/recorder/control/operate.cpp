#include "host/recorder/control/operate.hpp"

#include <memory>
#include <optional>
#include <random>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/clock/utc.hpp"
#include "common/record/folder.hpp"
#include "common/types/clocks.hpp"
#include "host/recorder/control/operating.hpp"
#include "host/recorder/control/recording_session.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kBusWait{20};

Operating::Time time_now() {
  return {.now = WallClock::now(), .utc_us = utc_us(), .slept = MachineClock::slept()};
}

}  // namespace

RecorderReport operate(std::stop_token stop, const OperateOptions& options) {
  OperateOptions wanted = options;
  wanted.recorder.folder = options.recordings;  // each recording gets one of its own
  refuse_mistakes(wanted.recorder);
  create_folders(options.recordings);
  std::random_device device;
  Bus bus(options.recorder.url);
  std::optional<Operating> operating;
  const auto begin = [&] {
    operating.emplace(wanted,
                      Operating::World{.disk = kernel_disk(),
                                       .begin = [](RecorderOptions of) -> std::unique_ptr<Session> {
                                         return std::make_unique<RecordingSession>(std::move(of));
                                       },

                                       .seed = (std::uint64_t{device()} << 32) | device(),
                                       .provide = reserve_heap_for},
                      time_now());
    wanted.start.reset();  // once
  };
  begin();
  for (const char* channels :
       {kRequestChannel, "RB_HEARTBEAT_.*", "RB_CLOCK_.*", "RB_REPLY_.*", "RB_PREVIEW_.*", "RB_BLOCK_.*"})
    bus.subscribe(channels, [&operating](std::string_view channel, auto bytes) {
      operating->take(channel, bytes, time_now());
    });
  const Publish publish = [&bus](const std::string& channel, std::span<const std::uint8_t> bytes) {
    return bus.publish(channel, bytes);
  };
  do {
    bus.handle(kBusWait);
    if (operating->has_another_disk()) begin();
  } while (operating->turn(stop.stop_requested(), time_now(), publish));
  return operating->report();
}

}  // namespace roadbalance
