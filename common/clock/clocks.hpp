#pragma once

#include <chrono>
#include <cstdint>

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

/// The monotonic clock of the machine a program runs on: protocol timers live here, samples never.
using WallClock = std::chrono::steady_clock;
using WallTime = WallClock::time_point;

constexpr NodeTime node_time_from_ns(std::int64_t ns) {
  return NodeTime(NodeClock::duration(ns));
}
constexpr std::int64_t to_ns(NodeTime time) {
  return time.time_since_epoch().count();
}
constexpr double to_seconds(NodeClock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace roadbalance
