#include "hil_tests/players/frame_player.hpp"

#include <cstdio>
#include <ctime>
#include <utility>

#include "common/clock/clock_pair.hpp"
#include "common/process/realtime.hpp"

namespace roadbalance::test {
namespace {

/// Like another device on the bus: no program of this machine holds it up, but its interrupts do.
constexpr int kPriority = 48;
constexpr auto kSlice = std::chrono::milliseconds(100);

/// False: told to stop.
bool sleep_until(MachineTime time, const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const MachineTime now = MachineClock::now();
    if (time <= now) return true;
    const bool last = time - now <= kSlice;
    const std::int64_t until_ns = to_ns(last ? time : now + kSlice) - machine_minus(CLOCK_MONOTONIC).count();
    const timespec until{.tv_sec = until_ns / 1'000'000'000, .tv_nsec = until_ns % 1'000'000'000};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
    if (last) return true;
  }
  return false;
}

}  // namespace

FramePlayer::FramePlayer(std::vector<DriveFrame> frames, const std::vector<std::string>& interfaces,
                         Timetable timetable)
    : frames_(std::move(frames)), timetable_(timetable) {
  for (const std::string& name : interfaces) bus_.push_back(std::make_unique<CanPlayer>(name));
}

void FramePlayer::run(std::stop_token stop) {
  for (const std::string& refused : enter_realtime(kPriority))
    std::fprintf(stderr, "rb-play: warning: %s\n", refused.c_str());
  for (const DriveFrame& frame : frames_) {
    const MachineTime time = timetable_.at(frame.time);
    if (!sleep_until(time, stop)) return;
    bus_[frame.interface]->send(frame.frame);
    lateness_.add((MachineClock::now() - time).count());
  }
}

}  // namespace roadbalance::test
