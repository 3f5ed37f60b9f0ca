#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hil_tests/guest/gpio_pulse/gpio_pulse.h"

namespace roadbalance::test {

/// Between starting a reader and the first edge.
inline constexpr std::int64_t kLead_ns = 20'000'000;

/// The guest's GPIO chip, whose inputs play levels on command; see gpio_pulse.h.
///
/// Only in the guest machine, and for one program at a time.
class PulseChip {
 public:
  /// @throws std::system_error if there is none, or another program plays
  PulseChip();
  ~PulseChip();
  PulseChip(const PulseChip&) = delete;
  PulseChip& operator=(const PulseChip&) = delete;

  /// CLOCK_MONOTONIC, in which steps and the kernel's stamps of edges are.
  static std::int64_t now_ns();
  /// Name of the character device, e.g. "gpiochip0".
  /// @throws std::runtime_error if the chip is unplugged
  static std::string name();

  /// Queues levels, times not decreasing; waits while the queue is full, which only played() empties.
  /// @throws std::system_error naming the reason
  void play(std::span<const gpio_pulse_step> steps);
  /// One level, now: what was queued before it has been played.
  void set(unsigned line, bool high);
  /// Steps played since the last call, each with its time; waits until all have been.
  std::vector<gpio_pulse_step> played();

  /// Removes the chip from the kernel and adds it again.  A step that is played meanwhile makes no edge, but
  /// sets the level.
  static void unplug();
  static void plug();
  /// Adds a second chip of the same label, whose lines play nothing, and removes it.
  static void plug_twin();
  static void unplug_twin();
  static std::string twin_name();

 private:
  int player_ = -1;
};

}  // namespace roadbalance::test
