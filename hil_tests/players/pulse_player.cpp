#include "hil_tests/players/pulse_player.hpp"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "common/process/pause.hpp"
#include "common/types/clock_pair.hpp"

namespace roadbalance::test {
namespace {

constexpr auto kAhead = std::chrono::seconds(1);
constexpr auto kPause = std::chrono::milliseconds(100);

}  // namespace

PulsePlayer::PulsePlayer(std::vector<DriveLevel> levels, Timetable timetable)
    : levels_(std::move(levels)), timetable_(timetable) {
  asked_ns_.reserve(levels_.size());
}

void PulsePlayer::run(std::stop_token stop) {
  std::jthread reader;
  do {
    queue_until(MachineClock::now() + kAhead);
    if (next_ > 0 && !reader.joinable()) reader = std::jthread([this, stop] { read_truth(stop); });
  } while (next_ < levels_.size() && pause(stop, kPause));
}

// The clocks are compared for each piece, for the kernel may slew the one that its timers run by.
void PulsePlayer::queue_until(MachineTime horizon) {
  const std::int64_t offset_ns = machine_minus(CLOCK_MONOTONIC).count();
  const std::lock_guard lock(mutex_);
  steps_.clear();
  for (; next_ < levels_.size() && timetable_.at(levels_[next_].time) <= horizon; ++next_) {
    const auto ns = static_cast<std::uint64_t>(to_ns(timetable_.at(levels_[next_].time)) - offset_ns);
    asked_ns_.push_back(asked_ns_.empty() ? ns : std::max(ns, asked_ns_.back()));
    steps_.push_back({asked_ns_.back(), levels_[next_].wire, levels_[next_].high});
  }
  if (!steps_.empty()) chip_.play(steps_);
}

/// Makes room in the chip's queue, which keeps every level until its truth was read.
void PulsePlayer::read_truth(std::stop_token stop) {
  for (std::size_t read = 0; read < levels_.size() && !stop.stop_requested();) {
    const auto truth = chip_.played();  // until the queue is empty, so mostly at the end
    const std::lock_guard lock(mutex_);
    for (const gpio_pulse_step& step : truth)
      lateness_.add(static_cast<std::int64_t>(step.t_ns - asked_ns_[read++]));
    if (truth.empty()) pause(stop, kPause);
  }
}

}  // namespace roadbalance::test
