#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <ctime>

namespace roadbalance {

/// The clock of a worker node: MachineClock on a board, bus time in the simulated car.
///
/// Every machine's clock is a type of its own, so times of two machines do not subtract by accident.
struct NodeClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = std::chrono::duration<rep, period>;
  using time_point = std::chrono::time_point<NodeClock>;
  static constexpr bool is_steady = true;
};
using NodeTime = NodeClock::time_point;

/// CLOCK_MONOTONIC_RAW of the machine a program runs on, and the time in which that was suspended: it is
/// never slewed, and steps only by a sleep.  The host's is the one time line of all nodes.
struct MachineClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = std::chrono::duration<rep, period>;
  using time_point = std::chrono::time_point<MachineClock>;
  static constexpr bool is_steady = true;

  static time_point now() noexcept {
    const duration awake = read(CLOCK_MONOTONIC_RAW);
    return time_point(awake + slept());
  }

  /// How long the machine was suspended since it was started: CLOCK_BOOTTIME minus CLOCK_MONOTONIC, without
  /// the noise of reading them one behind the other.  Sleeps of less than a millisecond are not seen.
  static duration slept() noexcept {
    constexpr rep kLeast_ns = 1'000'000;
    rep known = slept_ns_.load(std::memory_order_relaxed);
    const rep boot = read(CLOCK_BOOTTIME).count();
    if (std::abs(boot - read(CLOCK_MONOTONIC).count() - known) < kLeast_ns) return duration(known);
    const rep exact = boot_minus_monotonic_ns();
    if (std::abs(exact - known) >= kLeast_ns && slept_ns_.compare_exchange_strong(known, exact))
      return duration(exact);
    return duration(known);
  }

 private:
  static duration read(clockid_t clock) noexcept {
    timespec t{};
    clock_gettime(clock, &t);
    return std::chrono::seconds(t.tv_sec) + std::chrono::nanoseconds(t.tv_nsec);
  }
  // The narrowest of a few readings counts: an interruption between two would shift it.
  static rep boot_minus_monotonic_ns() noexcept {
    rep narrowest = INT64_MAX, difference = 0;
    for (int i = 0; i < 20 && narrowest > 1'000; ++i) {
      const rep before = read(CLOCK_MONOTONIC).count(), boot = read(CLOCK_BOOTTIME).count();
      const rep width = read(CLOCK_MONOTONIC).count() - before;
      if (width >= narrowest) continue;
      narrowest = width;
      difference = boot - (before + width / 2);
    }
    return difference;
  }

  static inline std::atomic<rep> slept_ns_{0};
};
using MachineTime = MachineClock::time_point;

/// The monotonic clock of the machine a program runs on: protocol timers live here, samples never.
using WallClock = std::chrono::steady_clock;
using WallTime = WallClock::time_point;

constexpr NodeTime node_time_from_ns(std::int64_t ns) {
  return NodeTime(NodeClock::duration(ns));
}
constexpr std::int64_t to_ns(NodeTime time) {
  return time.time_since_epoch().count();
}
constexpr MachineTime machine_time_from_ns(std::int64_t ns) {
  return MachineTime(MachineClock::duration(ns));
}
constexpr std::int64_t to_ns(MachineTime time) {
  return time.time_since_epoch().count();
}
constexpr std::int64_t to_ns(WallTime time) {
  return std::chrono::nanoseconds(time.time_since_epoch()).count();
}

/// An instant of hardware: a node with hardware lives in its machine's own clock.
constexpr NodeTime as_node_time(MachineTime time) {
  return node_time_from_ns(to_ns(time));
}
constexpr MachineTime as_machine_time(NodeTime time) {
  return machine_time_from_ns(to_ns(time));
}

constexpr double to_seconds(NodeClock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace roadbalance
