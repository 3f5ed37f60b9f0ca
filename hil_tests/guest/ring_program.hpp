#pragma once

#include <cstdint>
#include <vector>

#include "hil_tests/guest/gpio_pulse/gpio_pulse.h"

namespace roadbalance::test {

/// A pulse that is high for half its period; the line is low before and after.
void add_pulse(std::vector<gpio_pulse_step>& steps, unsigned line, std::int64_t begin_ns,
               std::int64_t period_ns);
/// So many of them, one after the other.
std::vector<gpio_pulse_step> pulses(unsigned line, std::int64_t begin_ns, std::int64_t period_ns, int count);
/// As PulseChip::play needs them.
std::vector<gpio_pulse_step> in_order(std::vector<gpio_pulse_step> steps);

/// A ring with a zero mark that turns evenly, as levels for the guest's chip.
struct RingProgram {
  unsigned tooth = 0, mark = 0;  ///< GPIOs
  int teeth = 0;
  double turns_hz = 0.0;
  std::int64_t begin_ns = 0;  ///< CLOCK_MONOTONIC, of the first zero mark
  int turns = 0;

  void add_to(std::vector<gpio_pulse_step>& steps) const;
  /// Turns since the first zero mark.
  double turns_at(std::int64_t monotonic_ns) const;
  std::int64_t time_ns(double after_turns) const;
};

/// How late the chip's timer played what it was asked to.
class PlayedLate {
 public:
  /// @param asked, played  of the same steps in the same order
  PlayedLate(const std::vector<gpio_pulse_step>& asked, const std::vector<gpio_pulse_step>& played);

  /// The most of any level of [from, to), ns; they are rounded outwards to milliseconds.
  std::int64_t most_ns(std::int64_t from_ns, std::int64_t to_ns) const;
  std::int64_t most_ns() const;

 private:
  std::int64_t begin_ms_ = 0;
  std::vector<std::int64_t> late_ns_;  ///< [millisecond]
};

}  // namespace roadbalance::test
