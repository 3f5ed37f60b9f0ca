#pragma once

#include "common/types/clocks.hpp"

namespace roadbalance::test {

/// When what happened in a drive happens again.
struct Timetable {
  MachineTime begin{};  ///< of the machine's clock,
  NodeTime first{};     ///< at this instant of the drive

  MachineTime at(NodeTime of_drive) const { return begin + (of_drive - first); }
};

/// How late things happened.
struct Lateness {
  std::int64_t count = 0;
  std::int64_t sum_ns = 0;
  std::int64_t worst_ns = 0;

  void add(std::int64_t late_ns) {
    ++count;
    sum_ns += late_ns;
    if (late_ns > worst_ns) worst_ns = late_ns;
  }
  double mean_ns() const {
    return count == 0 ? 0.0 : static_cast<double>(sum_ns) / static_cast<double>(count);
  }
};

}  // namespace roadbalance::test
