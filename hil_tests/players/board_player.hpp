#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hil_tests/players/node_drive.hpp"
#include "hil_tests/players/pulse_program.hpp"
#include "hil_tests/players/timetable.hpp"
#include "hil_tests/players/usb_board/bench_board.hpp"

namespace roadbalance::test {

/// Inputs of a front-end board while a drive is played: its converter finds scan k of the drive exactly at
/// the time of the timetable; before and after the drive, silence.
///
/// The board's oscillator is off by as much as the converter that took the drive was, and it begins its run
/// so that one of its conversions falls on the beginning of the drive: so every scan has its own conversion.
class BoardPlayer {
 public:
  /// @param capture  levels for the board's own encoder inputs: wire 2 line + 1 is the zero mark
  BoardPlayer(NodeDrive drive, std::vector<DriveLevel> capture, Timetable timetable);

  /// A board on which the drive is played; this must outlive it.
  Bench bench(const std::string& serial);

  /// How many of the drive's scans the board has converted, each once: a jump back is not counted.
  std::int64_t played() const { return played_.load(std::memory_order_relaxed); }

 private:
  using Nanoseconds = std::chrono::duration<double, std::nano>;
  MachineTime run_begin(MachineTime asked, Nanoseconds period);
  board::ScanWords words(MachineTime time);
  std::optional<LineChange> next_change();

  const NodeDrive drive_;
  const std::vector<DriveLevel> capture_;
  std::size_t next_level_ = 0;
  const Timetable timetable_;
  const MachineTime begin_;  ///< of the first scan
  Nanoseconds period_{0};
  std::atomic<std::int64_t> played_{0};
};

}  // namespace roadbalance::test
