#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>

#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "common/frontend/dropped_edges.hpp"
#include "common/types/blocks.hpp"
#include "firmware/backends/gpio/gpio_source.hpp"
#include "hil_tests/guest/pulse_chip.hpp"
#include "hil_tests/guest/ring_program.hpp"

namespace roadbalance::test {

/// Blocks of a node from edges.
struct Sealed {
  std::vector<ScanBlock> blocks;
  std::int64_t faulty_turns = 0;  ///< of line 0
};

/// The guest's chip, the backend on it, and what the backend gave.
class GpioRig {
 public:
  /// @param lines  GPIO numbers as in [[node.line]]; the vehicle is firmware/test/vehicle.hpp's
  explicit GpioRig(std::vector<LineConfig> lines, int teeth = 96);

  /// Plays, takes edges as they come until the backend reports that it has given all that was played, and
  /// keeps the truth.
  void play(const std::vector<gpio_pulse_step>& steps);
  /// Takes edges for so long.
  void take_for(std::int64_t duration_ns);
  /// Takes edges until the device has counted so many of these; fails after half a minute.
  void take_until(DeviceCounter counter, std::int64_t times);
  std::int64_t counted(DeviceCounter counter) const { return source->reports()[0]->of(counter); }
  std::size_t edges_of(EdgeKind kind, std::uint8_t line = 0) const;
  /// The edges beside scans of the same time, from an instant of CLOCK_MONOTONIC on, as a node seals them.
  Sealed seal(std::int64_t begin_ns, double seconds) const;

  PulseChip chip;
  VehicleConfig vehicle;
  std::string warnings;
  std::unique_ptr<SideSource> source;
  std::vector<Edge> edges;
  std::vector<gpio_pulse_step> truth;
  std::int64_t machine_minus_monotonic_ns = 0;
  bool in_real_time = false;  ///< edges may come late and are then marked as missing

 private:
  void take();
  bool take_for_a_moment(std::int64_t end_ns);
  DroppedEdges dropped_;
  NodeTime complete_ = NodeTime::min();
};

/// A thread of this priority that does nothing but burn the processor until an instant of CLOCK_MONOTONIC:
/// who is of lower priority does not run meanwhile.
std::jthread hog_processor(int priority, std::int64_t from_ns, std::int64_t until_ns);

}  // namespace roadbalance::test
