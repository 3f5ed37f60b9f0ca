#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace roadbalance::test {

/// From the shortest to the longest, in seconds; each time one between is drawn.
struct Span {
  double shortest_s = 0;
  double longest_s = 0;
};

/// Faults, in the order of kFaultNames.
enum class FaultKind : std::uint8_t {
  kPull,           ///< the cable of one node, or of all, is out
  kKillRecorder,   ///< kill -9; it is started again after `lasting`
  kKillNode,       ///< the same of a node: a new epoch
  kPauseRecorder,  ///< SIGSTOP, SIGCONT
  kPauseNode,      ///< the whole node; its device loses scans meanwhile
  kHangUplink,     ///< the node's link only: sampling goes on
  kPowerCut,       ///< of the host: what was not synced is gone or torn
  kDiskFull,       ///< of the host, and free again
  kDiskFailing,    ///< each call of the host's disk fails with `strength`
  kSpoolFailing,   ///< the same of a node's disk
  kWallStep,       ///< the host's wall clock jumps by up to a day either way
  kEndNode,        ///< a node ends in order, by one of its causes, and is started again after `lasting`
  kLateNode,       ///< a node that is expected comes so late; behind the drive's end: never
  kSuspendNode,    ///< the node's computer sleeps, and its device with it; its clock shows that
};
inline constexpr std::size_t kFaultKinds = 14;
inline constexpr std::array<const char*, kFaultKinds> kFaultNames{
    "pull",        "kill_recorder", "kill_node", "pause_recorder", "pause_node",
    "hang_uplink", "power_cut",     "disk_full", "disk_failing",   "spool_failing",
    "wall_step",   "end_node",      "late_node", "suspend_node"};

enum class Direction : std::uint8_t { kBoth, kToHost, kToNode };

/// [[fault]]: one kind, so many times in a part of the drive, evenly spread but for chance.
struct PlannedFault {
  FaultKind kind = FaultKind::kPull;
  double times = 1;             ///< in the whole of `seconds`
  double from = 0.1, to = 0.8;  ///< of the drive
  Span lasting{0.5, 0.5};
  Direction direction = Direction::kBoth;
  bool all_nodes = true;
  double strength = 1;
};

/// [expect]: what a run must reach beyond the promise itself.
struct Expectation {
  bool complete = false;     ///< nothing may be missing, not even declared
  bool absences = false;     ///< the record names each absence of a node, and no other
  bool falls_back = false;   ///< the record goes on in the fallback folder in half of the runs at least
  bool loses_edges = false;  ///< edges are lost inside gaps
  bool starts_late = false;  ///< a node hears of a start too late
  bool loses_signals = false;
  bool dies_at_calls = false;   ///< a recorder dies before a call of its disk once a run at least, on average
  bool dies_each_time = false;  ///< each kill and each power cut is a death of a recorder
  std::optional<double> sends_per_block, to_durable_s, pull_cleared_s, clock_coverage;
};

/// One file of hil_tests/deterministic/scenarios: a vehicle, a network, a disk and what happens to them.
struct FaultScenario {
  std::string name;
  double seconds = 120;       ///< of production
  double least_seconds = 10;  ///< a shorter run makes no sense
  int nodes = 2;
  int hosts = 1;               ///< recorders; all but the first start after `second_starts`
  double second_starts = 0.3;  ///< of the drive
  bool same_ids = false;       ///< every node calls itself number 1
  double rate_hz = 4000;
  double ring_mib = 4;
  double spool_mib = 0;  ///< 0: no spool
  double segment_mib = 4;
  double keep_mib = 0;    ///< retention; 0: everything is kept
  bool clocks = false;    ///< exchanges and fits
  bool fallback = false;  ///< each recorder has a folder on another disk, which does not fail

  double loss_to_host = 0, loss_to_node = 0;
  double duplicates = 0;
  double reordered = 0.02;  ///< share that comes 5 to 50 ms late
  double slow_syncs = 0;    ///< share of syncs that take ...
  Span slow_sync{0.5, 3};   ///< ... so long

  /// vehicle.toml that the recorder leads, which then starts, stops and sets up on request; empty: it records
  /// from its start on.
  std::string vehicle;
  bool is_operated() const { return !vehicle.empty(); }

  std::vector<PlannedFault> faults;
  bool plans(FaultKind kind) const {
    return std::ranges::find(faults, kind, &PlannedFault::kind) != faults.end();
  }
  Expectation expect;

  /// @throws ConfigError "file:line: key: reason", std::system_error
  static FaultScenario read_file(const std::string& path);
};

}  // namespace roadbalance::test
