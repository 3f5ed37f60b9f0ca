#include "hil_tests/players/frame_player.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "common/process/pause.hpp"
#include "common/process/realtime.hpp"

namespace roadbalance::test {
namespace {

/// Like another device on the bus: no program of this machine holds it up, but its interrupts do.
constexpr int kPriority = 48;
constexpr auto kSlice = std::chrono::milliseconds(100);

/// In slices, for pauses are not timed by the machine's clock.  False: asked to stop.
bool pause_until(MachineTime time, const std::stop_token& stop) {
  for (MachineTime now = MachineClock::now(); now < time; now = MachineClock::now())
    if (!pause(stop, std::min<MachineClock::duration>(time - now, kSlice))) return false;
  return !stop.stop_requested();
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
    if (!pause_until(time, stop)) return;
    bus_[frame.interface]->send(frame.frame);
    lateness_.add((MachineClock::now() - time).count());
  }
}

}  // namespace roadbalance::test
