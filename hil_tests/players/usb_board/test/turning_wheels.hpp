#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "hil_tests/players/usb_board/bench_board.hpp"

namespace roadbalance::test {

/// A wheel that turns evenly, with two tracks and a zero mark once a turn.
struct TurningWheel {
  std::size_t line = 0;
  int teeth = 1000;
  double turns_hz = 20.0;
  bool backward = false;
  MachineTime begin = MachineClock::now();  ///< of tooth 0

  /// The mark lies behind every tooth whose number is a multiple of `teeth`, in parts of a tooth.  It is
  /// stamped at one and the same of its ends, which the wheel passes first forward and last backward.
  static constexpr double kMarkBegin = 0.1, kMarkEnd = 0.2;
  double mark() const { return backward ? kMarkEnd : kMarkBegin; }

  /// When the wheel has turned so far, in teeth.
  double seconds_of(double way) const { return way / (turns_hz * teeth); }
  /// The inverse, of seconds since `begin`.
  double way_at(double since_begin_s) const { return since_begin_s * turns_hz * teeth; }
};

/// Changes of a bench's wires by such wheels, in order of time, for Bench::next_change.
class TurningWheels {
 public:
  explicit TurningWheels(const std::vector<TurningWheel>& wheels) {
    for (const TurningWheel& wheel : wheels) program_.push_back({wheel, 0, 0, {}});
    for (Program& program : program_) program.next = change_of(program);
  }
  std::optional<LineChange> operator()() {
    Program* first = &program_.front();
    for (Program& program : program_)
      if (program.next.time < first->next.time) first = &program;
    const LineChange change = first->next;
    do first->part = (first->part + 1) % kParts, first->tooth += first->part == 0;
    while (is_mark(first->part) && first->tooth % first->wheel.teeth != 0);
    first->next = change_of(*first);
    return change;
  }

 private:
  static constexpr int kParts = 6;  ///< A, the mark's two ends, B, A, B
  struct Program {
    TurningWheel wheel;
    std::int64_t tooth;
    int part;
    LineChange next;
  };
  static bool is_mark(int part) { return part == 1 || part == 2; }

  /// Forward A leads B by a quarter of a tooth; backward it is the other way about.
  static LineChange change_of(const Program& program) {
    constexpr std::array<double, kParts> kAt{0.0, TurningWheel::kMarkBegin, TurningWheel::kMarkEnd, 0.25, 0.5,
                                             0.75};
    constexpr std::array kSignal{board::Signal::kA, board::Signal::kZero, board::Signal::kZero,
                                 board::Signal::kB, board::Signal::kA,    board::Signal::kB};
    constexpr std::array kHigh{true, true, false, true, false, false};
    const auto part = static_cast<std::size_t>(program.part);
    const double at_s = program.wheel.seconds_of(static_cast<double>(program.tooth) + kAt[part]);
    const bool is_a = kSignal[part] == board::Signal::kA;
    return {program.wheel.begin + MachineClock::duration(std::llround(1e9 * at_s)), program.wheel.line,
            kSignal[part], kHigh[part] != (is_a && program.wheel.backward)};
  }

  std::vector<Program> program_;
};

}  // namespace roadbalance::test
