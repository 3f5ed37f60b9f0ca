#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/bus/compensation.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/results.hpp"

namespace roadbalance {

/// Results as a person reads them in the terminal.

/// "front left:  heavy spot 217°, 35 g, ± 2 g ± 3°", or why it is not known.
std::string balance_line(const Balance& balance);

/// The remedy: weights to add, move or remove, or to leave the wheel alone; the remainder by the limits; and
/// why weights will not cure it, if so.  None if it is not known.
std::vector<std::string> advice_lines(const Balance& balance, const Compensation& compensation);

/// The first of these alone: "add 15 g at 37°" for each step, or to leave the wheel alone; none: not known.
std::vector<std::string> step_words(const Compensation& compensation);

/// The remainder: "leaves 0.6 g, within what a shop leaves (7 g), ...; at 90–130 km/h": the speeds of which
/// the balance is the correction.
std::string left_words(const Balance& balance, const Compensation& compensation);

/// "from 48 s of driving; tyres 214 ± 2 209 ± 2 221 ± 3 206 ± 2 kN/m"; or why not.
/// @param missing  why the drive does not determine it, or the source of that; used if it does not
std::string identification_line(const Identification& identification,
                                const std::string& missing = "rb identify says what is missing");

/// "springs 30.1 ± 0.1 ... kN/m; dampers 1440 ± 4 ... N s/m" by wheel and "stabilisers 12.0 ± 0.2 ... kN/m";
/// none if they are not known.
std::vector<std::string> suspension_lines(const Identification& identification);

/// A standard deviation as it is shown beside a value: no less than one of the value's last digits, for none
/// is exact.  NaN stays NaN.
double shown_sigma(double sigma, double last_digit);

/// "node 1: 12000 samples taken, 0 missing, 3 blocks repaired, memory 2 % full, lasts 640 s, obeys recorder
/// 1763741000000"; its disk is mentioned if it is used or refuses.
/// @param memory_left_s  time until the memory is full if recording stops, as far as it is known
std::string node_line(const Heartbeat& heartbeat, std::optional<double> memory_left_s);

/// "devices: gone 1, bus_errors 5": what the node's devices have suffered; empty if nothing.
std::string device_line(const Heartbeat& heartbeat);

/// One line a channel with a bar of its rms.
std::vector<std::string> level_lines(const Level& level);

std::string reason(Unknown state);

/// Rewrites a block of lines in place on a terminal; elsewhere prints those that changed.
class Screen {
 public:
  Screen();
  /// @param news  something happened that a log should hold, if it shows in the lines
  void draw(const std::vector<std::string>& lines, bool news);

 private:
  void log(const std::vector<std::string>& lines);

  bool terminal_;
  std::size_t drawn_ = 0;
  std::vector<std::string> logged_;
};

}  // namespace roadbalance
