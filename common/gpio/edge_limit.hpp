#pragma once

#include <algorithm>
#include <chrono>

#include "common/gpio/gpio_chip.hpp"

namespace roadbalance {

/// The fastest wheel that is measured: 300 km/h on a small one.
inline constexpr double kMostTurns_hz = 60.0;

/// How late threads may wake up on a machine.
struct WakeUps {
  std::chrono::nanoseconds interrupt_thread{};  ///< of the priority of the kernel's interrupt threads
  std::chrono::nanoseconds reader{};            ///< of that of a program that reads edges
};

/// Edges a second of one line of which surely none is lost: the kernel's interrupt thread has to take one
/// before the next comes, and the reader has to come before the kernel holds more than it keeps.
inline double edge_limit_hz(const WakeUps& worst) {
  const auto seconds = [](std::chrono::nanoseconds time) {
    return std::max(1e-9, std::chrono::duration<double>(time).count());
  };
  return std::min(1.0 / seconds(worst.interrupt_thread),
                  static_cast<double>(GpioChip::kKernelEvents) / seconds(worst.reader));
}

}  // namespace roadbalance
