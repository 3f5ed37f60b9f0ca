#pragma once

#include <cstddef>

namespace roadbalance {

/// Bytes of memory that this machine can still give (MemAvailable of /proc/meminfo); infinity if that is not
/// known.
double available_memory();

/// To look at both sides of each edge all those of a drive are in memory at once.  Reports that they will be
/// too many before the machine suffers.
class EdgeMemory {
 public:
  /// Most of all while a wheel's angle is computed: measured 94 of one wheel alone, 54 of four, whose turn
  /// comes one after the other.
  static constexpr double kBytesAnEdge = 100.0;

  /// @param available  bytes that may be used
  explicit EdgeMemory(double available = available_memory()) : available_(available) {}

  /// So many more are to be held.
  /// @throws std::runtime_error with the figures if they are too many
  void add(std::size_t edges);

 private:
  double available_, edges_ = 0.0;
};

}  // namespace roadbalance
