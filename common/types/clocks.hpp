#pragma once

#include <chrono>
#include <cstdint>
#include <ctime>

namespace roadbalance {

/// The clock of a worker node: CLOCK_MONOTONIC_RAW on a board, bus time in the simulated car.
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

/// CLOCK_MONOTONIC_RAW of the machine a program runs on: it is never stepped or slewed.  The host's is the
/// one time line of all nodes.
struct MachineClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = std::chrono::duration<rep, period>;
  using time_point = std::chrono::time_point<MachineClock>;
  static constexpr bool is_steady = true;

  static time_point now() noexcept {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC_RAW, &t);
    return time_point(std::chrono::seconds(t.tv_sec) + std::chrono::nanoseconds(t.tv_nsec));
  }
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
