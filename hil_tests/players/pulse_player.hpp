#pragma once

#include <mutex>
#include <stop_token>
#include <vector>

#include "hil_tests/guest/pulse_chip.hpp"
#include "hil_tests/players/pulse_program.hpp"
#include "hil_tests/players/timetable.hpp"

namespace roadbalance::test {

/// Plays levels on the lines of the guest's GPIO chip: DriveLevel::wire is the line's number on the chip.
class PulsePlayer {
 public:
  /// @throws std::system_error if there is no such chip, or another program plays
  PulsePlayer(std::vector<DriveLevel> levels, Timetable timetable);

  /// Process: ends when all is played, or when asked to.
  void run(std::stop_token stop);

  /// Lateness of levels: how late the chip's timer was.  After run().
  const Lateness& lateness() const { return lateness_; }

 private:
  void read_truth(std::stop_token stop);
  void queue_until(MachineTime horizon);

  const std::vector<DriveLevel> levels_;
  const Timetable timetable_;
  PulseChip chip_;
  std::size_t next_ = 0;
  std::vector<gpio_pulse_step> steps_;
  std::mutex mutex_;
  std::vector<std::uint64_t> asked_ns_;  ///< of levels queued, CLOCK_MONOTONIC; under the mutex
  Lateness lateness_;
};

}  // namespace roadbalance::test
