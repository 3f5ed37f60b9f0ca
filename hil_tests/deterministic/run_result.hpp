#pragma once

#include <array>
#include <cstdint>

namespace roadbalance::test {

/// Result of one run; plain bytes, so that it passes through a pipe.
struct RunResult {
  std::uint64_t seed = 0;
  double bus_s = 0;           ///< simulated
  double processor_s = 0;     ///< spent
  std::int64_t blocks = 0;    ///< sealed
  std::int64_t recorded = 0;  ///< blocks found in records
  std::int64_t sent = 0;      ///< datagrams with blocks
  std::int64_t scans = 0;
  std::int64_t lost_scans = 0;      ///< undeclared
  std::int64_t declared_scans = 0;  ///< in gaps
  std::int64_t declared_gaps = 0;
  std::int64_t tail_scans = 0;  ///< behind the last block of a node that died
  double longest_to_durable_s = 0;
  double longest_pull_cleared_s = 0;
  std::int64_t lost_edges = 0;  ///< inside gaps
  std::int64_t late_starts = 0;
  std::int64_t lost_signals = 0;
  std::int64_t recorder_boots = 0;
  std::int64_t deaths_at_call = 0;  ///< of recorders, before a call of their disk
  std::int64_t node_boots = 0;
  std::int64_t fallbacks = 0;     ///< recorders whose record goes on in the fallback folder
  std::int64_t disk_fulls = 0;    ///< times that a recorder waited for space
  std::int64_t clock_events = 0;  ///< exchanges and fits found in records
  std::int64_t clock_windows = 0;
  std::int64_t clock_covered = 0;
  std::int64_t faults = 0;        ///< promises broken
  std::array<char, 1600> what{};  ///< the first of them, one a line

  bool operator==(const RunResult&) const = default;
};

}  // namespace roadbalance::test
